// In: a picture and what to say about it, or the path of an EXR file. Out: the bytes of a file, or a picture.
// Files are encoded to and decoded from memory, so that output_file alone writes and text_file alone reads.
// Damaged files are met in two steps: checkAttributes and readHeaders look at all that a file claims before anything
// is allocated for it; what is left (damaged pixels) OpenEXR notices itself.
#include "image/exr.h"

#include <Iex.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfTileDescription.h>
#include <ImfVersion.h>
#include <ImfXdr.h>

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <new>
#include <string_view>
#include <utility>
#include <vector>

#include "base/errors.h"
#include "base/text_file.h"
#include "scene/scene.h"

namespace turner {
namespace {

constexpr const char* kChannels[] = {"R", "G", "B"};
constexpr size_t kPixelBytes = 3 * sizeof(float);
// The largest picture that is read: 3 GiB of floats.
constexpr int64_t kMaxPixels = int64_t(1) << 28;
// The magic number and the version, before the first header.
constexpr size_t kStartBytes = 8;
// Level of zlib's compression; stated because OpenEXR's default is a variable of the process.
constexpr int kZipLevel = 4;

class StringOut : public Imf::OStream {
 public:
  StringOut() : OStream("picture") {}
  void write(const char c[], int n) override {
    const size_t end = position_ + size_t(n);
    if (bytes.size() < end) bytes.resize(end);
    std::memcpy(bytes.data() + position_, c, size_t(n));
    position_ = end;
  }
  uint64_t tellp() override { return position_; }
  void seekp(uint64_t position) override { position_ = position; }

  std::string bytes;

 private:
  size_t position_ = 0;
};

class StringIn : public Imf::IStream {
 public:
  StringIn(const std::string& path, std::string_view bytes) : IStream(path.c_str()), bytes_(bytes) {}
  bool read(char c[], int n) override {
    if (n < 0 || position_ > bytes_.size() || size_t(n) > bytes_.size() - position_) {
      throw Iex::InputExc("the file ends too early");
    }
    std::memcpy(c, bytes_.data() + position_, size_t(n));
    position_ += size_t(n);
    return position_ < bytes_.size();
  }
  uint64_t tellg() override { return position_; }
  void seekg(uint64_t position) override { position_ = position; }

 private:
  std::string_view bytes_;
  uint64_t position_ = 0;
};

// OpenEXR multiplies row vectors from the left, GLM column vectors from the right: the same map is the transpose. As
// Imath stores rows and GLM stores columns, the transpose has the same indices.
Imath::M44f transposeForImath(const glm::dmat4& columns) {
  Imath::M44f rows;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) rows[i][j] = float(columns[i][j]);
  }
  return rows;
}

// The pixels of `rgb` as OpenEXR sees them: three interleaved channels over the data window.
Imf::FrameBuffer makeFrameBuffer(const float* rgb, const Imath::Box2i& dataWindow) {
  const size_t width = size_t(dataWindow.max.x - dataWindow.min.x) + 1;
  Imf::FrameBuffer frame;
  for (int c = 0; c < 3; ++c) {
    frame.insert(kChannels[c], Imf::Slice::Make(Imf::FLOAT, rgb + c, dataWindow, kPixelBytes, kPixelBytes * width));
  }
  return frame;
}

// Steps over one zero-terminated text; throws if the file ends before it does.
std::string_view takeText(std::string_view& rest) {
  const size_t end = rest.find('\0');
  if (end == std::string_view::npos) throw InputError("the header ends too early");
  const std::string_view text = rest.substr(0, end);
  rest.remove_prefix(end + 1);
  return text;
}

// Walks over the attributes (name, type, size, value) of all headers and throws if one claims to be longer than the
// file: OpenEXR would allocate first and notice later.
void checkAttributes(std::string_view bytes, int version) {
  std::string_view rest = bytes.substr(kStartBytes);
  bool first = true;
  for (;;) {
    const std::string_view name = takeText(rest);
    if (name.empty()) {
      // A header ends with an empty name; the list of headers of a multi-part file ends with an empty header.
      if (first || !Imf::isMultiPart(version)) return;
      first = true;
      continue;
    }
    first = false;
    takeText(rest);
    if (rest.size() < 4) throw InputError("the header ends too early");
    uint32_t size = 0;
    for (int i = 3; i >= 0; --i) size = size << 8 | uint8_t(rest[size_t(i)]);
    rest.remove_prefix(4);
    if (size > rest.size()) {
      throw InputError("the attribute '" + std::string(name.substr(0, 40)) + "' is longer than the file");
    }
    rest.remove_prefix(size);
  }
}

// Throws if a window is empty, inside out, or larger than any picture Turner makes.
void checkWindow(const char* name, const Imath::Box2i& box) {
  const int64_t width = int64_t(box.max.x) - box.min.x + 1, height = int64_t(box.max.y) - box.min.y + 1;
  if (width > 0 && height > 0 && width <= kMaxSize && height <= kMaxSize && width * height <= kMaxPixels) return;
  throw InputError("its " + std::string(name) + " window of " + std::to_string(width) + " x " + std::to_string(height) +
                   " pixels is not between 1 x 1 and " + std::to_string(kMaxSize) + " x " + std::to_string(kMaxSize) +
                   " with at most " + std::to_string(kMaxPixels) + " pixels in all");
}

bool hasRgb(const Imf::ChannelList& channels) {
  return std::all_of(std::begin(kChannels), std::end(kChannels),
                     [&](const char* name) { return channels.findChannel(name) != nullptr; });
}

// What to do about a file without R, G and B, where one can see it.
std::string remedyFor(const Imf::ChannelList& channels) {
  if (channels.findChannel("Y")) return "; convert its luminance (and chroma) to R, G, B first";
  for (auto c = channels.begin(); c != channels.end(); ++c) {
    const std::string name = c.name();
    if (name.size() > 2 && name.ends_with(".R"))
      return "; write the layer '" + name.substr(0, name.size() - 2).substr(0, 60) + "' into a file as R, G, B first";
  }
  return "";
}

std::string namesOf(const Imf::ChannelList& channels) {
  std::string names;
  for (auto c = channels.begin(); c != channels.end(); ++c)
    names += (names.empty() ? "" : ", ") + std::string(c.name());
  return names;
}

// A channel that has no value for some pixels; empty if there is none.
std::string subsampledOf(const Imf::ChannelList& channels) {
  for (const char* name : kChannels) {
    const Imf::Channel& channel = channels[name];
    if (channel.xSampling != 1 || channel.ySampling != 1) return name;
  }
  return "";
}

// The parts that have a flat picture in R, G and B.
struct Parts {
  std::vector<int> withRgb;
  std::string found, remedy, deep, subsampled;  // of the others: their channels, and what to do about them
};

// Reads the headers alone. Throws if a part claims an absurd size.
Parts readHeaders(const std::string& path, std::string_view bytes, int version) {
  Parts parts;
  StringIn in(path, bytes);
  in.seekg(kStartBytes);
  for (int part = 0;; ++part) {
    Imf::Header header;
    header.readFrom(in, version);
    if (header.readsNothing()) return parts;
    checkWindow("display", header.displayWindow());
    checkWindow("data", header.dataWindow());
    if (header.hasTileDescription()) {
      const Imf::TileDescription& tile = header.tileDescription();
      if (tile.xSize < 1 || tile.ySize < 1 || tile.xSize > unsigned(kMaxSize) || tile.ySize > unsigned(kMaxSize)) {
        throw InputError("its tiles of " + std::to_string(tile.xSize) + " x " + std::to_string(tile.ySize) +
                         " pixels are not between 1 x 1 and " + std::to_string(kMaxSize) + " x " +
                         std::to_string(kMaxSize));
      }
    }
    const Imf::ChannelList& channels = header.channels();
    if (header.hasType() && Imf::isDeepData(header.type())) {
      parts.deep = header.type();
    } else if (hasRgb(channels)) {
      const std::string subsampled = subsampledOf(channels);
      if (subsampled.empty())
        parts.withRgb.push_back(part);
      else
        parts.subsampled = subsampled;
    } else {
      parts.found += (parts.found.empty() ? "" : ", ") + namesOf(channels);
      if (parts.remedy.empty()) parts.remedy = remedyFor(channels);
    }
    if (!Imf::isMultiPart(version)) return parts;
  }
}

// The number of the part to read; throws if there is none.
int choosePart(const Parts& parts) {
  if (!parts.withRgb.empty()) return parts.withRgb[0];
  if (!parts.subsampled.empty())
    throw InputError("its channel " + parts.subsampled + " is subsampled; every pixel needs a value");
  if (!parts.deep.empty() && parts.found.empty())
    throw InputError("its picture is deep (" + parts.deep + "); flatten it first");
  throw InputError("needs the channels R, G and B; found " +
                   (parts.found.empty() ? "none" : parts.found.substr(0, 200)) + parts.remedy);
}

// Throws InputError with a bare reason, or what OpenEXR throws.
ExrPicture decodeExr(const std::string& path, std::string_view bytes) {
  // Read what the file claims.
  if (bytes.size() < kStartBytes || !Imf::isImfMagic(bytes.data())) {
    throw InputError(bytes.empty() ? "is empty" : "is not an OpenEXR file");
  }
  int version = 0;
  StringIn start(path, bytes.substr(4));
  Imf::Xdr::read<Imf::StreamIO>(start, version);
  if (Imf::getVersion(version) != Imf::EXR_VERSION || !Imf::supportsFlags(Imf::getFlags(version))) {
    throw InputError("is of an unknown version of OpenEXR");
  }
  checkAttributes(bytes, version);
  const Parts parts = readHeaders(path, bytes, version);
  const int number = choosePart(parts);

  // Open it, and make sure that all of its pixels are there before making room for them.
  StringIn in(path, bytes);
  Imf::MultiPartInputFile file(in);
  const Imf::Header& header = file.header(number);
  if (!file.partComplete(number)) throw InputError("is incomplete: pixels are missing");

  // Read the pixels; coordinates count from the corner of the display window.
  Imf::InputPart part(file, number);
  const Imath::Box2i display = header.displayWindow(), data = header.dataWindow();
  const Imath::V2i corner = display.min;
  ExrPicture picture;
  picture.image =
      Image(display.max.x - corner.x + 1, display.max.y - corner.y + 1,
            Window{data.min.x - corner.x, data.min.y - corner.y, data.max.x - corner.x + 1, data.max.y - corner.y + 1});
  part.setFrameBuffer(makeFrameBuffer(picture.image.rgb.data(), data));
  part.readPixels(data.min.y, data.max.y);

  // What the numbers mean.
  if (Imf::hasChromaticities(header)) {
    const Imf::Chromaticities& c = Imf::chromaticities(header);
    picture.chromaticities = {c.red.x, c.red.y, c.green.x, c.green.y, c.blue.x, c.blue.y, c.white.x, c.white.y};
  }
  picture.pixelAspectRatio = header.pixelAspectRatio();
  picture.isCoarse = header.find("turner:coarse") != header.end();
  picture.candidates = int(parts.withRgb.size());
  if (header.hasName()) picture.part = header.name();
  return picture;
}

}  // namespace

std::string encodeExr(const Image& image, const Provenance& provenance) {
  const Window& window = image.window;
  assert(window.width() > 0 && window.height() > 0 && image.rgb.size() == 3 * window.area());
  try {
    // Describe the picture.
    const Imath::Box2i display({0, 0}, {image.width - 1, image.height - 1});
    const Imath::Box2i data({window.x0, window.y0}, {window.x1 - 1, window.y1 - 1});
    Imf::Header header(display, data, provenance.pixelAspectRatio, {0, 0}, 1, Imf::INCREASING_Y, Imf::ZIP_COMPRESSION);
    header.zipCompressionLevel() = kZipLevel;
    for (const char* name : kChannels) header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    const Chromaticities& c = provenance.chromaticities;
    Imf::addChromaticities(header, Imf::Chromaticities({c[0], c[1]}, {c[2], c[3]}, {c[4], c[5]}, {c[6], c[7]}));
    for (const auto& [name, value] : provenance.strings) header.insert(name, Imf::StringAttribute(value));
    if (provenance.worldToCamera) Imf::addWorldToCamera(header, transposeForImath(*provenance.worldToCamera));
    if (provenance.worldToNdc) Imf::addWorldToNDC(header, transposeForImath(*provenance.worldToNdc));

    // Write it; the file's table of contents is filled in when `file` ends.
    StringOut out;
    {
      Imf::OutputFile file(out, header);
      file.setFrameBuffer(makeFrameBuffer(image.rgb.data(), data));
      file.writePixels(window.height());
    }
    return std::move(out.bytes);
  } catch (const Iex::BaseExc& fault) {
    throw RunError(std::string("OpenEXR cannot encode the picture: ") + fault.what());
  }
}

ExrPicture readExrPicture(const std::string& path) {
  const std::string bytes = readTextFile(path), name = nameOfInput(path);
  try {
    return decodeExr(name, bytes);
  } catch (const InputError& fault) {
    throw InputError(name + ": error: " + fault.what());
  } catch (const std::bad_alloc&) {
    throw InputError(name + ": error: needs more memory than there is");
  } catch (const std::exception& fault) {
    std::string reason = fault.what();
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw InputError(name + ": error: is damaged: " + reason);
  }
}

Image readExr(const std::string& path) {
  return std::move(readExrPicture(path).image);
}

}  // namespace turner
