// Three passes. First every setting on every renderer once, keeping the pictures; then the converged picture, which
// must be better than the best of these; then the repeats, in turn, so that a slow minute of the machine does not fall
// on one setting, each with a seed of its own, so that errors are those of the sampler and not of one draw.
#include "report/measure.h"

#include <algorithm>
#include <cmath>

#include "base/errors.h"
#include "image/provenance.h"

namespace turner::report {
namespace {

// The error of a pixel's channel above which it is bad, as compare has it.
constexpr double kThreshold = 1e-3;
// A converged picture may come from a renderer whose float32 is wrong by at most this share of the least error.
constexpr double kFarSmaller = 0.1;

double samplesIn(const RenderSettings& settings) {
  return double(settings.crop.area()) * settings.samples * settings.samples;
}

// NaN where pixels are no numbers: compareImages would leave them out.
double rmseOf(const Comparison& comparison) {
  return comparison.nan + comparison.inf > 0 ? std::nan("") : comparison.rmse;
}
double rmsError(const Image& a, const Image& b) {
  return rmseOf(compareImages(a, b, kThreshold));
}

Image partOf(const Image& image, const Window& part) {
  Image result(image.width, image.height, part);
  for (int y = part.y0; y < part.y1; ++y) {
    const size_t from = size_t(y - image.window.y0) * size_t(image.window.width()) + size_t(part.x0 - image.window.x0);
    std::copy_n(image.rgb.begin() + std::ptrdiff_t(3 * from), 3 * part.width(),
                result.rgb.begin() + std::ptrdiff_t(3 * size_t(y - part.y0) * size_t(part.width())));
  }
  return result;
}

std::string pointName(const SceneToSweep& sweep, const std::string& renderer, const Setting& setting) {
  return sweep.tag + renderer + '-' + settingName(setting, sweep.whole);
}

int mostSamples(const SceneToSweep& sweep) {
  return sweep.settings.back().samples;  // they are sorted
}

// Samples of the first converged picture that is tried.
double firstConverged(const SceneToSweep& sweep) {
  return firstConvergedSamples(mostSamples(sweep)) * double(sweep.whole.crop.area());
}

class Measuring {
 public:
  Measuring(const SceneToSweep& sweep, std::vector<std::unique_ptr<Renderer>> renderers, Journal& journal,
            SweepObserver& observer)
      : sweep_(sweep),
        renderers_(std::move(renderers)),
        rounded_(referenceRenderer(sweep.scene, ReferenceOf::rounded)),
        journal_(journal),
        observer_(observer) {}

  SweptScene run() {
    SweptScene result;
    // Every setting once.
    for (const Setting& setting : sweep_.settings) {
      for (size_t i = 0; i < renderers_.size(); ++i) tryFirst(i, setting, result.failures);
      measureFirst(*rounded_, setting);
    }

    result.convergedBy = chooseConverged();
    result.converged = convergeOn(result.convergedBy.renderer);
    if (result.convergedBy.renderer != reference() && !isTrusted(result)) {
      result.convergedBy = {reference(), 0};
      result.converged = convergeOn(reference());
    }
    settle(result.convergedBy.renderer);

    // The repeats in turn.
    for (int repeat = 1; repeat < sweep_.repeats; ++repeat)
      for (const Setting& setting : sweep_.settings)
        for (const auto& renderer : renderers_) measureAgain(*renderer, setting, repeat, result.converged.mean);

    for (const Setting& setting : sweep_.settings) {
      const Split split = splitOf(setting, result.converged);
      for (size_t i = 0; i < renderers_.size(); ++i)
        result.points.push_back(pointOf(i, setting, split, result.converged));
    }
    for (const auto& renderer : renderers_) result.renderers.push_back(renderer->info);
    return result;
  }

 private:
  // The parts of a setting's error that come from the reference; the same for all devices.
  struct Split {
    Image rounded;
    Comparison sampling, cutOff, quantisation;
  };

  size_t reference() const { return renderers_.size() - 1; }
  Image pictureOf(const std::string& renderer, const Setting& setting) const {
    return journal_.picture(pointName(sweep_, renderer, setting));
  }
  double secondsOf(const Renderer& renderer, const Setting& setting) const {
    return journal_.find(pointName(sweep_, renderer.info.name, setting), 0)->seconds;
  }
  // The last setting that is nothing but the most samples of a sampler.
  Setting finest(Sampler sampler) const {
    Setting found = sweep_.settings.front();
    for (const Setting& setting : sweep_.settings)
      if (setting.sampler == sampler && setting == uncut(setting, sweep_.whole)) found = setting;
    return found;
  }

  TimedPicture render(Renderer& renderer, const RenderSettings& settings, const std::string& what) {
    const double samples = samplesIn(settings);
    double reported = 0;
    const auto report = [&](double share) {
      observer_.done(renderer.info.name, share * samples - reported, what);
      reported = share * samples;
    };
    TimedPicture picture = renderer.render(settings, report);
    report(1);
    return picture;
  }

  void measureFirst(Renderer& renderer, const Setting& setting) {
    const std::string point = pointName(sweep_, renderer.info.name, setting);
    const RenderSettings settings = settingsWith(sweep_.whole, setting, 0);
    if (journal_.find(point, 0)) {
      if (journal_.hasPicture(point, settings.width, settings.height, settings.crop)) return;
      observer_.expect(renderer.info.name, samplesIn(settings));
    }
    const TimedPicture picture = render(renderer, settings, point);
    const RendererInfo& info = renderer.info;
    journal_.keep(point, picture.image, makeProvenance(sweep_.scene, settings, info.origin, info.device, info.driver));
    journal_.add(point, 0, {.seconds = picture.seconds, .meanSquare = -1});
  }

  void measureAgain(Renderer& renderer, const Setting& setting, int repeat, const Image& converged) {
    const std::string point = pointName(sweep_, renderer.info.name, setting);
    if (journal_.find(point, repeat)) return;
    const TimedPicture picture = render(renderer, settingsWith(sweep_.whole, setting, uint32_t(repeat)), point);
    const double rmse = rmsError(picture.image, converged);
    journal_.add(point, repeat, {.seconds = picture.seconds, .meanSquare = rmse * rmse});
  }

  // A device that cannot render the scene is left out, if there is another one.
  void tryFirst(size_t& i, const Setting& setting, std::vector<std::string>& failures) {
    try {
      measureFirst(*renderers_[i], setting);
    } catch (const RunError& error) {
      if (i == reference() || renderers_.size() <= 2) throw;
      failures.push_back(renderers_[i]->info.name + " cannot render this scene: " + error.what());
      renderers_.erase(renderers_.begin() + std::ptrdiff_t(i--));
    }
  }

  // Of a device's converged picture. What was known of its float32 came from fewer samples, and was compared with an
  // estimate of the least error; now that is known, and the reference renders a sixteenth of the picture once more.
  bool isTrusted(SweptScene& result) {
    double& floatError = result.convergedBy.floatError;
    const Converged& converged = result.converged;
    RenderSettings settings =
        settingsWith(sweep_.whole, {Sampler::sobol, converged.samples, sweep_.whole.depth, 0}, kConvergedSeeds[1]);
    const Window& whole = sweep_.whole.crop;
    const int width = std::max(1, whole.width() / 4), height = std::max(1, whole.height() / 4);
    const int x = whole.x0 + (whole.width() - width) / 2, y = whole.y0 + (whole.height() - height) / 2;
    settings.crop = {x, y, x + width, y + height};
    observer_.expect(renderers_[reference()]->info.name, samplesIn(settings));
    const Image exact = render(*renderers_[reference()], settings, sweep_.tag + "converged").image;
    floatError = std::max(floatError, rmsError(partOf(converged.sobol, settings.crop), exact));
    const double bound = kFarSmaller * converged.leastError;
    return std::isfinite(bound) && floatError <= bound;
  }

  // The fastest renderer that computes well enough: two samplers' pictures with the most samples estimate the least
  // error, and the reference's pictures at the same samples show how far float32 is off.
  ConvergedBy chooseConverged() const {
    const Setting best = finest(Sampler::sobol);
    const std::string& exact = renderers_[reference()]->info.name;
    const Setting other = finest(best.samples > 1 ? Sampler::jitter : Sampler::grid);
    const double leastError = rmsError(pictureOf(exact, best), pictureOf(exact, other)) / std::sqrt(2.0);
    ConvergedBy chosen{reference(), 0};
    const auto settled = journal_.decision(sweep_.tag + "converged");
    for (size_t i = 0; i < reference(); ++i) {
      const std::string& name = renderers_[i]->info.name;
      double floatError = 0;
      for (const Sampler sampler : {Sampler::jitter, Sampler::sobol}) {
        const Setting setting = finest(sampler);
        const double error = rmsError(pictureOf(name, setting), pictureOf(exact, setting));
        if (!(error <= floatError)) floatError = error;  // a NaN stays
      }
      const bool isFaster = secondsOf(*renderers_[i], best) < secondsOf(*renderers_[chosen.renderer], best);
      const bool fits = settled ? *settled == name : isFaster && floatError <= kFarSmaller * leastError;
      if (fits) chosen = {i, floatError};
    }
    return chosen;
  }

  // From here on figures are against this one, also when an interrupted sweep is taken up.
  void settle(size_t renderer) {
    const std::string key = sweep_.tag + "converged";
    if (!journal_.decision(key)) journal_.decide(key, renderers_[renderer]->info.name);
  }

  Converged convergeOn(size_t renderer) {
    const RendererInfo& info = renderers_[renderer]->info;
    std::string key = info.name + ' ' + info.content;
    for (const SourceFile& source : sweep_.scene.sources) key += ' ' + source.sha256;
    double expected = 0, rendered = 0;
    const RenderPicture renderThere = [&](const RenderSettings& settings) {
      rendered += samplesIn(settings);
      return render(*renderers_[renderer], settings, sweep_.tag + "converged").image;
    };
    const auto leastErrorAgainst = [&](const Image& mean, double ownError) {
      double least = HUGE_VAL;
      for (const Setting& setting : sweep_.settings)
        for (const auto& candidate : renderers_) {
          const Image picture = pictureOf(candidate->info.name, setting);
          least = std::min(least, withoutOwnError(rmsError(picture, mean), ownError));
        }
      return least;
    };
    if (!convergedIsExpected_) observer_.expect(renderers_[reference()]->info.name, -firstConverged(sweep_));
    convergedIsExpected_ = true;
    const Converged converged =
        converge(cached(renderThere, key), sweep_.whole, mostSamples(sweep_), leastErrorAgainst, [&](double samples) {
          samples *= double(sweep_.whole.crop.area());
          expected += samples;
          observer_.expect(info.name, samples);
        });
    observer_.expect(info.name, rendered - expected);  // what the cache had
    return converged;
  }

  Split splitOf(const Setting& setting, const Converged& converged) const {
    const std::string& name = renderers_[reference()]->info.name;
    Split split;
    const Image exact = pictureOf(name, setting), whole = pictureOf(name, uncut(setting, sweep_.whole));
    split.rounded = pictureOf(rounded_->info.name, setting);
    split.sampling = compareImages(whole, converged.mean, kThreshold);
    split.sampling.rmse = withoutOwnError(split.sampling.rmse, converged.ownError);
    split.cutOff = compareImages(exact, whole, kThreshold);
    split.quantisation = compareImages(split.rounded, exact, kThreshold);
    return split;
  }

  SweepPoint pointOf(size_t renderer, const Setting& setting, const Split& split, const Converged& converged) const {
    SweepPoint point;
    point.renderer = renderer;
    point.setting = setting;
    point.name = renderers_[renderer]->info.name + '-' + settingName(setting, sweep_.whole);
    const std::string name = pointName(sweep_, renderers_[renderer]->info.name, setting);
    const Image picture = journal_.picture(name);
    point.total = compareImages(picture, converged.mean, kThreshold);
    point.sampling = split.sampling;
    point.cutOff = split.cutOff;
    if (renderer == reference()) {
      point.arithmetic = point.quantisation = compareImages(picture, picture, kThreshold);
    } else {
      point.quantisation = split.quantisation;
      point.arithmetic = compareImages(picture, split.rounded, kThreshold);
    }
    double squares = 0;
    for (int repeat = 0; repeat < sweep_.repeats; ++repeat) {
      const Measurement measurement = *journal_.find(name, repeat);
      point.seconds.push_back(measurement.seconds);
      const double rmse = repeat == 0 ? rmseOf(point.total) : std::sqrt(measurement.meanSquare);
      point.rmses.push_back(withoutOwnError(rmse, converged.ownError));
      squares += point.rmses.back() * point.rmses.back();
    }
    point.rmse = std::sqrt(squares / sweep_.repeats);
    point.relRmse = withoutOwnError(point.total.relRmse, converged.ownRelative);
    return point;
  }

  const SceneToSweep& sweep_;
  std::vector<std::unique_ptr<Renderer>> renderers_;
  std::unique_ptr<Renderer> rounded_;
  Journal& journal_;
  SweepObserver& observer_;
  bool convergedIsExpected_ = false;  // by its own renderer
};

}  // namespace

void expectSweep(const SceneToSweep& sweep, const std::vector<RendererInfo>& renderers, const Journal& journal,
                 SweepObserver& observer) {
  const auto expect = [&](const std::string& renderer, const Setting& setting, int repeats) {
    for (int repeat = 0; repeat < repeats; ++repeat)
      if (!journal.find(pointName(sweep, renderer, setting), repeat))
        observer.expect(renderer, samplesIn(settingsWith(sweep.whole, setting, 0)));
  };
  for (const Setting& setting : sweep.settings) {
    for (const RendererInfo& renderer : renderers) expect(renderer.name, setting, sweep.repeats);
    expect("rounded", setting, 1);
  }
  // Who renders the converged picture is not known yet.
  observer.expect(renderers.back().name, firstConverged(sweep));
}

SweptScene measure(const SceneToSweep& sweep, std::vector<std::unique_ptr<Renderer>> renderers, Journal& journal,
                   SweepObserver& observer) {
  SweptScene result = Measuring(sweep, std::move(renderers), journal, observer).run();
  result.summary.name = sweep.scene.name;
  result.summary.sources = sweep.scene.sources;
  result.summary.depth = sweep.scene.depth;
  result.path = sweep.path;
  result.stem = sweep.stem;
  result.primitives = sweep.scene.primitiveCounts();
  result.whole = sweep.whole;
  return result;
}

}  // namespace turner::report
