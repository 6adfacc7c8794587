// Tables of figures, for people and for programs.
#include "hard/report.h"

#include <fmt/format.h>
#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>

#include <algorithm>
#include <cmath>

namespace turner::hard {
namespace {

// Counts as they are, all else with three digits.
std::string formatFigure(double value) {
  if (value == std::floor(value) && std::abs(value) < 1e6) return fmt::format("{:.0f}", value);
  return fmt::format("{:.3g}", value);
}

}  // namespace

void Report::add(Figure figure) {
  figures_.push_back(std::move(figure));
  reached_.emplace_back();
}

void Report::atMost(const std::string& what, double turner, double bar, std::optional<double> naive,
                    const std::string& note) {
  add({what, naive, turner, bar, note});
}

void Report::atMostSeconds(const std::string& what, double turner, double bar) {
  add({what, {}, turner, bar, {}, true});
}

void Report::knownMiss(const std::string& what, double turner, double bar, const KnownMiss& known,
                       std::optional<double> naive) {
  add({what, naive, turner, bar, known.why});
  reached_.back() = known.reached;
}

bool Report::passes() const {
  return std::all_of(figures_.begin(), figures_.end(), [](const Figure& figure) { return figure.passes(); });
}

bool Report::holdsWhatIsReached(bool withTimes) const {
  for (size_t i = 0; i < figures_.size(); ++i)
    if (!figures_[i].passes() && (withTimes || !figures_[i].isTime) &&
        !(reached_[i] && figures_[i].turner <= *reached_[i]))
      return false;
  return !figures_.empty();
}

std::string markdownTable(const std::vector<Scored>& cases, const RunFacts& facts) {
  std::string text = "| case | figure | naive float32 | Turner | bar | |\n| --- | --- | ---: | ---: | ---: | --- |\n";
  size_t figures = 0, passed = 0;
  for (const Scored& scored : cases) {
    bool first = true;
    for (const Figure& figure : scored.report.figures()) {
      ++figures;
      passed += figure.passes();
      text += fmt::format("| {} | {}{} | {} | {} | {} | {} |\n",
                          first ? fmt::format("{}. {}", scored.number, scored.name) : "", figure.what,
                          figure.note.empty() ? "" : " (" + figure.note + ")",
                          figure.naive ? formatFigure(*figure.naive) : "", formatFigure(figure.turner),
                          formatFigure(figure.bar), figure.passes() ? "pass" : "**fails**");
      first = false;
    }
  }
  return text + fmt::format("\n{} of {} figures of {} cases pass. {}, {} counts, seed {}.\n", passed, figures,
                            cases.size(), facts.device, facts.effort, facts.seed);
}

std::string jsonTable(const std::vector<Scored>& cases, const RunFacts& facts) {
  rapidjson::StringBuffer buffer;
  rapidjson::PrettyWriter<rapidjson::StringBuffer> json(buffer);
  json.SetIndent(' ', 2);
  // JSON has no NaN and no infinity.
  const auto number = [&](const char* key, double value) {
    json.Key(key);
    if (std::isfinite(value))
      json.Double(value);
    else
      json.Null();
  };
  const auto string = [&](const char* key, const std::string& value) {
    json.Key(key);
    json.String(value.c_str());
  };
  json.StartObject();
  string("device", facts.device);
  string("effort", facts.effort);
  json.Key("seed");
  json.Uint64(facts.seed);
  json.Key("cases");
  json.StartArray();
  for (const Scored& scored : cases) {
    json.StartObject();
    json.Key("number");
    json.Int(scored.number);
    string("name", scored.name);
    number("seconds", scored.seconds);
    json.Key("passes");
    json.Bool(scored.report.passes());
    json.Key("figures");
    json.StartArray();
    for (const Figure& figure : scored.report.figures()) {
      json.StartObject();
      string("what", figure.what);
      if (figure.naive) number("naive", *figure.naive);
      number("turner", figure.turner);
      number("bar", figure.bar);
      if (!figure.note.empty()) string("note", figure.note);
      json.Key("passes");
      json.Bool(figure.passes());
      json.EndObject();
    }
    json.EndArray();
    json.EndObject();
  }
  json.EndArray();
  json.EndObject();
  return std::string(buffer.GetString()) + '\n';
}

}  // namespace turner::hard
