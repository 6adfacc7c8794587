// EXR files as OpenEXR itself reads and writes them, and files that are wrong in every way.
#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/vec4.hpp>
#include <iterator>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "base/errors.h"
#include "image/exr.h"

namespace turner {
namespace {

// A file that goes away at the end of the test.
class ScratchFile {
 public:
  ScratchFile() : path(testing::TempDir() + "turner_exr_" + std::to_string(getpid()) + ".exr") {}
  explicit ScratchFile(const std::string& bytes) : ScratchFile() { write(bytes); }
  ~ScratchFile() { std::filesystem::remove(path); }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  void write(const std::string& bytes) const { std::ofstream(path, std::ios::binary) << bytes; }
  std::string read() const {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  const std::string path;
};

// Smooth values, so that compression has work to do, different in each channel.
Image makePattern(int width, int height, Window window) {
  Image image(width, height, window);
  size_t i = 0;
  for (int y = window.y0; y < window.y1; ++y) {
    for (int x = window.x0; x < window.x1; ++x) {
      for (int c = 0; c < 3; ++c)
        image.rgb[i++] = 0.1f * float(c) + std::sin(0.1f * float(x)) * std::cos(0.2f * float(y));
    }
  }
  return image;
}

Image makePattern(int width, int height) {
  return makePattern(width, height, Window{0, 0, width, height});
}

Image decode(const std::string& bytes) {
  return readExr(ScratchFile(bytes).path);
}

void expectSameBits(const Image& a, const Image& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.window, b.window);
  ASSERT_EQ(a.rgb.size(), b.rgb.size());
  for (size_t i = 0; i < a.rgb.size(); ++i) {
    ASSERT_EQ(std::bit_cast<uint32_t>(a.rgb[i]), std::bit_cast<uint32_t>(b.rgb[i])) << "value " << i;
  }
}

// The reason for which a file is refused; checks that it names the file.
std::string refusalOf(const std::string& path) {
  try {
    readExr(path);
  } catch (const InputError& error) {
    const std::string message = error.what(), start = path + ": error: ";
    EXPECT_EQ(message.substr(0, start.size()), start);
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  }
  return "no error";
}

void expectRefused(const std::string& bytes, const std::string& reason) {
  const std::string message = refusalOf(ScratchFile(bytes).path);
  EXPECT_NE(message.find(reason), std::string::npos) << message;
}

// Overwrites the first occurrence of an attribute's value; `type` is as long as its size field says.
std::string patchAttribute(std::string bytes, const std::string& name, const std::string& type, size_t offset,
                           int32_t value) {
  const std::string start = name + '\0' + type + '\0';
  const size_t place = bytes.find(start);
  EXPECT_NE(place, std::string::npos);
  std::memcpy(bytes.data() + place + start.size() + offset, &value, sizeof value);
  return bytes;
}

constexpr size_t kSizeField = 0, kMinX = 4, kMinY = 8, kMaxX = 12, kMaxY = 16;

// A header with channels of one pixel type.
Imf::Header makeHeader(int width, int height, const std::vector<std::string>& channels, Imf::PixelType type) {
  Imf::Header header(width, height);
  for (const std::string& name : channels) header.channels().insert(name, Imf::Channel(type));
  return header;
}

template <typename Value>
Imf::FrameBuffer makeFrame(const std::vector<Value>& values, int width, const std::vector<std::string>& channels,
                           Imf::PixelType type) {
  const size_t stride = sizeof(Value) * channels.size();
  Imf::FrameBuffer frame;
  for (size_t c = 0; c < channels.size(); ++c) {
    char* base = reinterpret_cast<char*>(const_cast<Value*>(values.data() + c));
    frame.insert(channels[c], Imf::Slice(type, base, stride, stride * size_t(width)));
  }
  return frame;
}

const std::vector<std::string> kRgb = {"R", "G", "B"};

TEST(Exr, EveryBitOfAFloatSurvivesTheRoundTrip) {
  using Limits = std::numeric_limits<float>;
  Image image(3, 3, Window{0, 0, 3, 3});
  const std::vector<float> special = {0.0f,
                                      -0.0f,
                                      Limits::denorm_min(),
                                      -Limits::denorm_min(),
                                      1e-40f,
                                      Limits::min(),
                                      Limits::max(),
                                      -Limits::max(),
                                      Limits::infinity(),
                                      -Limits::infinity(),
                                      Limits::quiet_NaN(),
                                      std::bit_cast<float>(0xffc12345u),
                                      1 + Limits::epsilon(),
                                      1.0f / 3,
                                      65504.0f,
                                      65520.0f,
                                      1e-8f};
  std::copy(special.begin(), special.end(), image.rgb.begin());
  expectSameBits(decode(encodeExr(image, {})), image);
}

TEST(Exr, RandomBitsSurviveTheRoundTrip) {
  Image image(67, 53, Window{0, 0, 67, 53});
  std::mt19937 random(1);
  for (float& value : image.rgb) value = std::bit_cast<float>(uint32_t(random()));
  expectSameBits(decode(encodeExr(image, {})), image);
}

TEST(Exr, ACropKeepsItsPlaceInTheFullPicture) {
  const Image image = makePattern(100, 80, Window{10, 20, 43, 59});
  expectSameBits(decode(encodeExr(image, {})), image);
}

TEST(Exr, ACropOfOnePixelInTheLastCornerKeepsItsPlace) {
  const Image image = makePattern(100, 80, Window{99, 79, 100, 80});
  expectSameBits(decode(encodeExr(image, {})), image);
}

TEST(Exr, TheHeaderSaysWhatOtherProgramsExpect) {
  const ScratchFile file(encodeExr(makePattern(100, 80, Window{10, 20, 43, 59}), {}));
  Imf::InputFile in(file.path.c_str());
  const Imf::Header& header = in.header();
  EXPECT_EQ(header.displayWindow(), Imath::Box2i({0, 0}, {99, 79}));
  EXPECT_EQ(header.dataWindow(), Imath::Box2i({10, 20}, {42, 58}));
  EXPECT_EQ(header.compression(), Imf::ZIP_COMPRESSION);
  std::vector<std::string> names;
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
    names.push_back(c.name());
    EXPECT_EQ(c.channel().type, Imf::FLOAT);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"B", "G", "R"}));
  ASSERT_TRUE(Imf::hasChromaticities(header));
  EXPECT_EQ(Imf::chromaticities(header),
            Imf::Chromaticities({0.64f, 0.33f}, {0.30f, 0.60f}, {0.15f, 0.06f}, {0.3127f, 0.3290f}));
}

TEST(Exr, StringsStandUnderTheirNames) {
  const std::string longValue(5000, 'v');
  const ScratchFile file(encodeExr(makePattern(4, 4), {.strings = {{"turner.device", "a device, \xc3\xa9"},
                                                                   {"a name that is longer than 31 characters", ""},
                                                                   {"scene", longValue}}}));
  Imf::InputFile in(file.path.c_str());
  const auto value = [&in](const char* name) { return in.header().typedAttribute<Imf::StringAttribute>(name).value(); };
  EXPECT_EQ(value("turner.device"), "a device, \xc3\xa9");
  EXPECT_EQ(value("a name that is longer than 31 characters"), "");
  EXPECT_EQ(value("scene"), longValue);
  EXPECT_EQ(decode(file.read()).width, 4);
}

TEST(Exr, MatricesMapPointsAlikeInBothConventions) {
  glm::dmat4 toCamera, toNdc;
  for (int i = 0; i < 16; ++i) {
    toCamera[i / 4][i % 4] = 0.25 * i - 1;
    toNdc[i / 4][i % 4] = 3 + i * i;
  }
  const ScratchFile file(encodeExr(makePattern(4, 4), {.worldToCamera = toCamera, .worldToNdc = toNdc}));
  Imf::InputFile in(file.path.c_str());
  ASSERT_TRUE(Imf::hasWorldToCamera(in.header()));
  ASSERT_TRUE(Imf::hasWorldToNDC(in.header()));
  const auto expectSameMap = [](const glm::dmat4& columns, const Imath::M44f& rows) {
    const glm::dvec4 expected = columns * glm::dvec4(1, 2, 3, 4);
    const Imath::V4f mapped = Imath::V4f(1, 2, 3, 4) * rows;
    for (int i = 0; i < 4; ++i) EXPECT_EQ(double(mapped[i]), expected[i]) << i;
  };
  expectSameMap(toCamera, Imf::worldToCamera(in.header()));
  expectSameMap(toNdc, Imf::worldToNDC(in.header()));
}

TEST(Exr, MatricesThatAreNotGivenAreNotWritten) {
  const ScratchFile file(encodeExr(makePattern(4, 4), {}));
  Imf::InputFile in(file.path.c_str());
  EXPECT_FALSE(Imf::hasWorldToCamera(in.header()));
  EXPECT_FALSE(Imf::hasWorldToNDC(in.header()));
}

TEST(Exr, TheHeaderHoldsNothingBesideWhatIsKnown) {
  const ScratchFile file(encodeExr(makePattern(4, 4), {.strings = {{"scene", "x"}}}));
  Imf::InputFile in(file.path.c_str());
  std::set<std::string> names;
  for (auto a = in.header().begin(); a != in.header().end(); ++a) names.insert(a.name());
  // OpenEXR adds "type" as it reads.
  names.erase("type");
  EXPECT_EQ(names, (std::set<std::string>{"channels", "chromaticities", "compression", "dataWindow", "displayWindow",
                                          "lineOrder", "pixelAspectRatio", "scene", "screenWindowCenter",
                                          "screenWindowWidth"}));
}

TEST(Exr, BytesDependOnTheArgumentsAlone) {
  const Image image = makePattern(201, 151);
  const Provenance provenance{.strings = {{"scene", "x"}}, .worldToCamera = glm::dmat4(1)};
  const std::string bytes = encodeExr(image, provenance);
  EXPECT_EQ(encodeExr(image, provenance), bytes);

  Imf::setGlobalThreadCount(4);
  EXPECT_EQ(encodeExr(image, provenance), bytes) << "with four threads";
  expectSameBits(decode(bytes), image);
  Imf::setGlobalThreadCount(0);

  Imf::setDefaultZipCompressionLevel(9);
  EXPECT_EQ(encodeExr(image, provenance), bytes) << "with another default level";
  Imf::setDefaultZipCompressionLevel(4);
}

TEST(Exr, EveryLosslessCompressionIsRead) {
  const Image image = makePattern(70, 41);
  for (const Imf::Compression compression :
       {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION}) {
    const ScratchFile file;
    Imf::Header header = makeHeader(70, 41, kRgb, Imf::FLOAT);
    header.compression() = compression;
    {
      Imf::OutputFile out(file.path.c_str(), header);
      out.setFrameBuffer(makeFrame(image.rgb, 70, kRgb, Imf::FLOAT));
      out.writePixels(41);
    }
    SCOPED_TRACE(compression);
    expectSameBits(readExr(file.path), image);
  }
}

TEST(Exr, LossyCompressionsAreReadNearly) {
  const Image image = makePattern(70, 41);
  for (const Imf::Compression compression : {Imf::PXR24_COMPRESSION, Imf::B44_COMPRESSION, Imf::B44A_COMPRESSION,
                                             Imf::DWAA_COMPRESSION, Imf::DWAB_COMPRESSION}) {
    const ScratchFile file;
    Imf::Header header = makeHeader(70, 41, kRgb, Imf::FLOAT);
    header.compression() = compression;
    {
      Imf::OutputFile out(file.path.c_str(), header);
      out.setFrameBuffer(makeFrame(image.rgb, 70, kRgb, Imf::FLOAT));
      out.writePixels(41);
    }
    SCOPED_TRACE(compression);
    const Image back = readExr(file.path);
    ASSERT_EQ(back.rgb.size(), image.rgb.size());
    for (size_t i = 0; i < back.rgb.size(); ++i) ASSERT_NEAR(back.rgb[i], image.rgb[i], 0.05f);
  }
}

TEST(Exr, HalfAndIntegerChannelsBecomeFloats) {
  const ScratchFile file;
  const std::vector<half> halves = {half(0.5f),     half(-2.0f),         half(0.0999755859375f),
                                    half(65504.0f), half(5.9604645e-8f), half(-0.0f)};
  {
    Imf::OutputFile out(file.path.c_str(), makeHeader(2, 1, kRgb, Imf::HALF));
    out.setFrameBuffer(makeFrame(halves, 2, kRgb, Imf::HALF));
    out.writePixels(1);
  }
  EXPECT_EQ(readExr(file.path).rgb, (std::vector<float>{0.5f, -2, 0.0999755859375f, 65504, 0x1p-24f, -0.0f}));

  const std::vector<uint32_t> integers = {0, 1, 7, 100, 65536, 1u << 31};
  {
    Imf::OutputFile out(file.path.c_str(), makeHeader(2, 1, kRgb, Imf::UINT));
    out.setFrameBuffer(makeFrame(integers, 2, kRgb, Imf::UINT));
    out.writePixels(1);
  }
  EXPECT_EQ(readExr(file.path).rgb, (std::vector<float>{0, 1, 7, 100, 65536, 0x1p31f}));
}

TEST(Exr, OtherChannelsArePassedOver) {
  const ScratchFile file;
  const std::vector<std::string> channels = {"R", "G", "B", "A", "N.X", "Z"};
  const std::vector<float> values = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  {
    Imf::OutputFile out(file.path.c_str(), makeHeader(2, 1, channels, Imf::FLOAT));
    out.setFrameBuffer(makeFrame(values, 2, channels, Imf::FLOAT));
    out.writePixels(1);
  }
  EXPECT_EQ(readExr(file.path).rgb, (std::vector<float>{1, 2, 3, 7, 8, 9}));
}

TEST(Exr, TiledPicturesAreReadAtTheirFullSize) {
  const Image image = makePattern(37, 29);
  for (const Imf::LevelMode mode : {Imf::ONE_LEVEL, Imf::MIPMAP_LEVELS, Imf::RIPMAP_LEVELS}) {
    const ScratchFile file;
    Imf::Header header = makeHeader(37, 29, kRgb, Imf::FLOAT);
    header.setTileDescription(Imf::TileDescription(16, 8, mode));
    {
      Imf::TiledOutputFile out(file.path.c_str(), header);
      for (int ly = 0; ly < out.numYLevels(); ++ly) {
        for (int lx = 0; lx < out.numXLevels(); ++lx) {
          if (!out.isValidLevel(lx, ly)) continue;
          // Smaller levels hold other values, so that reading the wrong one shows.
          std::vector<float> values(image.rgb.size(), -1.0f);
          if (lx == 0 && ly == 0) values = image.rgb;
          out.setFrameBuffer(makeFrame(values, 37, kRgb, Imf::FLOAT));
          out.writeTiles(0, out.numXTiles(lx) - 1, 0, out.numYTiles(ly) - 1, lx, ly);
        }
      }
    }
    SCOPED_TRACE(mode);
    expectSameBits(readExr(file.path), image);
  }
}

TEST(Exr, CoordinatesCountFromTheDisplayWindowsCorner) {
  const ScratchFile file;
  Imf::Header header(Imath::Box2i({-5, 100}, {4, 109}), Imath::Box2i({-3, 102}, {-2, 102}));
  for (const std::string& name : kRgb) header.channels().insert(name, Imf::Channel(Imf::FLOAT));
  const std::vector<float> values = {1, 2, 3, 4, 5, 6};
  {
    Imf::OutputFile out(file.path.c_str(), header);
    Imf::FrameBuffer frame;
    for (size_t c = 0; c < 3; ++c) {
      frame.insert(kRgb[c], Imf::Slice::Make(Imf::FLOAT, values.data() + c, header.dataWindow(), 12, 24));
    }
    out.setFrameBuffer(frame);
    out.writePixels(1);
  }
  const Image image = readExr(file.path);
  EXPECT_EQ(image.width, 10);
  EXPECT_EQ(image.height, 10);
  EXPECT_EQ(image.window, (Window{2, 2, 4, 3}));
  EXPECT_EQ(image.rgb, values);
}

TEST(Exr, OfManyPartsTheFirstIsRead) {
  const Image image = makePattern(20, 10);
  const ScratchFile file;
  std::vector<Imf::Header> headers(2, makeHeader(20, 10, kRgb, Imf::FLOAT));
  headers[0].setName("first");
  headers[1].setName("second");
  for (Imf::Header& header : headers) header.setType(Imf::SCANLINEIMAGE);
  {
    Imf::MultiPartOutputFile out(file.path.c_str(), headers.data(), 2);
    const std::vector<float> black(image.rgb.size());
    for (int part : {0, 1}) {
      Imf::OutputPart output(out, part);
      output.setFrameBuffer(makeFrame(part == 0 ? image.rgb : black, 20, kRgb, Imf::FLOAT));
      output.writePixels(10);
    }
  }
  expectSameBits(readExr(file.path), image);
}

TEST(Exr, APartWithoutRgbIsPassedOver) {
  const Image image = makePattern(20, 10);
  const ScratchFile file;
  const std::vector<std::string> depth = {"Z"};
  std::vector<Imf::Header> headers = {makeHeader(20, 10, depth, Imf::FLOAT), makeHeader(20, 10, kRgb, Imf::FLOAT),
                                      makeHeader(20, 10, kRgb, Imf::FLOAT)};
  for (size_t i = 0; i < headers.size(); ++i) {
    headers[i].setName(std::string("part ") + char('0' + i));
    headers[i].setType(Imf::SCANLINEIMAGE);
  }
  {
    Imf::MultiPartOutputFile out(file.path.c_str(), headers.data(), int(headers.size()));
    const std::vector<float> black(image.rgb.size());
    for (int part : {0, 1, 2}) {
      Imf::OutputPart output(out, part);
      output.setFrameBuffer(makeFrame(part == 1 ? image.rgb : black, 20, part == 0 ? depth : kRgb, Imf::FLOAT));
      output.writePixels(10);
    }
  }
  const ExrPicture picture = readExrPicture(file.path);
  expectSameBits(picture.image, image);
  EXPECT_EQ(picture.part, "part 1");
  EXPECT_EQ(picture.candidates, 2);
}

TEST(Exr, WhatTheNumbersMeanSurvivesTheRoundTrip) {
  Provenance provenance;
  provenance.chromaticities = {0.7f, 0.3f, 0.2f, 0.7f, 0.1f, 0.05f, 0.33f, 0.34f};
  provenance.pixelAspectRatio = 2;
  const ExrPicture picture = readExrPicture(ScratchFile(encodeExr(makePattern(4, 4), provenance)).path);
  EXPECT_EQ(picture.chromaticities, provenance.chromaticities);
  EXPECT_EQ(picture.pixelAspectRatio, 2);
  EXPECT_EQ(readExrPicture(ScratchFile(encodeExr(makePattern(4, 4), {})).path).chromaticities, kRec709);
}

TEST(Exr, ADeepPictureIsRefusedAsDeep) {
  const ScratchFile file;
  Imf::Header header = makeHeader(2, 1, kRgb, Imf::FLOAT);
  header.setType(Imf::DEEPSCANLINE);
  header.compression() = Imf::ZIPS_COMPRESSION;
  {
    unsigned counts[2] = {1, 1};
    float value = 1;
    float* samples[2] = {&value, &value};
    Imf::DeepScanLineOutputFile out(file.path.c_str(), header);
    Imf::DeepFrameBuffer frame;
    frame.insertSampleCountSlice(
        Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts), sizeof(unsigned), 2 * sizeof(unsigned)));
    for (const std::string& name : kRgb) {
      frame.insert(name, Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(samples), sizeof(float*),
                                        2 * sizeof(float*), sizeof(float)));
    }
    out.setFrameBuffer(frame);
    out.writePixels(1);
  }
  const std::string message = refusalOf(file.path);
  EXPECT_NE(message.find("is deep"), std::string::npos) << message;
}

TEST(Exr, AMissingChannelIsRefusedNamingThoseFound) {
  for (const auto& [channels, found] :
       {std::pair<std::vector<std::string>, std::string>{{"Y"}, "found Y"}, {{"R", "G", "Z"}, "found G, R, Z"}}) {
    const ScratchFile file;
    const std::vector<float> values(channels.size());
    {
      Imf::OutputFile out(file.path.c_str(), makeHeader(1, 1, channels, Imf::FLOAT));
      out.setFrameBuffer(makeFrame(values, 1, channels, Imf::FLOAT));
      out.writePixels(1);
    }
    const std::string message = refusalOf(file.path);
    EXPECT_NE(message.find("needs the channels R, G and B; " + found), std::string::npos) << message;
  }
}

TEST(Exr, ASubsampledChannelIsRefused) {
  const ScratchFile file;
  Imf::Header header(2, 2);
  const std::vector<float> values(4);
  Imf::FrameBuffer frame;
  for (const std::string& name : kRgb) {
    const int sampling = name == "G" ? 2 : 1;
    header.channels().insert(name, Imf::Channel(Imf::FLOAT, sampling, sampling));
    char* base = reinterpret_cast<char*>(const_cast<float*>(values.data()));
    frame.insert(name, Imf::Slice(Imf::FLOAT, base, 4, 8, sampling, sampling));
  }
  {
    Imf::OutputFile out(file.path.c_str(), header);
    out.setFrameBuffer(frame);
    out.writePixels(2);
  }
  const std::string message = refusalOf(file.path);
  EXPECT_NE(message.find("channel G is subsampled"), std::string::npos) << message;
}

TEST(Exr, AFileThatIsMissingOrAFolderIsRefused) {
  EXPECT_NE(refusalOf(testing::TempDir() + "no_such_file.exr").find("No such file"), std::string::npos);
  const std::string folder = std::filesystem::temp_directory_path().string();
  EXPECT_NE(refusalOf(folder).find("folder"), std::string::npos);
}

TEST(Exr, GarbageIsRefused) {
  expectRefused("", "is empty");
  expectRefused("v/1\x01", "is not an OpenEXR file");
  expectRefused("\x89PNG\r\n\x1a\n and so on", "is not an OpenEXR file");
  expectRefused(std::string("v/1\x01\x09\0\0\0\0", 9), "unknown version");
  expectRefused(std::string("v/1\x01\x02\xff\0\0\0", 9), "unknown version");
  expectRefused(std::string("v/1\x01\x02\0\0\0", 8) + std::string(1000, 'x'), "the header ends too early");
  expectRefused(std::string("v/1\x01\x02\0\0\0\0", 9), "error");
  expectRefused(std::string("v/1\x01\x02\x10\0\0\0", 9), "error");
}

TEST(Exr, AbsurdWindowsAreRefusedBeforeRoomIsMadeForThem) {
  const std::string bytes = encodeExr(makePattern(4, 4), {});
  const auto patch = [&](const char* name, size_t offset, int32_t value) {
    return patchAttribute(bytes, name, "box2i", offset, value);
  };
  const int32_t huge = std::numeric_limits<int32_t>::max();
  expectRefused(patch("dataWindow", kMaxX, huge), "data window of 2147483648 x 4 pixels");
  expectRefused(patch("dataWindow", kMaxY, huge), "data window of 4 x 2147483648 pixels");
  expectRefused(patch("dataWindow", kMinX, std::numeric_limits<int32_t>::min()),
                "data window of 2147483652 x 4 pixels");
  expectRefused(patch("dataWindow", kMinY, 5), "data window of 4 x -1 pixels");
  expectRefused(patch("dataWindow", kMaxX, 65536), "data window of 65537 x 4 pixels");
  expectRefused(patch("displayWindow", kMaxX, huge - 1), "display window of 2147483647 x 4 pixels");
  expectRefused(patchAttribute(patch("dataWindow", kMaxX, 65535), "dataWindow", "box2i", kMaxY, 65535),
                "data window of 65536 x 65536 pixels");
  // Large but allowed: the pixels are missing, and that is found out before room is made for 2^28 of them.
  expectRefused(patchAttribute(patch("dataWindow", kMaxX, 4095), "dataWindow", "box2i", kMaxY, 65535), "error");
}

TEST(Exr, AbsurdAttributeSizesAreRefused) {
  const std::string bytes = encodeExr(makePattern(4, 4), {.strings = {{"scene", "x"}}});
  for (const int32_t size : {std::numeric_limits<int32_t>::max(), -1, std::numeric_limits<int32_t>::min(), 1 << 20}) {
    expectRefused(patchAttribute(bytes, "scene", "string", kSizeField, size),
                  "the attribute 'scene' is longer than the file");
    expectRefused(patchAttribute(bytes, "channels", "chlist", kSizeField, size),
                  "the attribute 'channels' is longer than the file");
  }
}

TEST(Exr, AbsurdTilesAreRefused) {
  const ScratchFile file;
  Imf::Header header = makeHeader(4, 4, kRgb, Imf::FLOAT);
  header.setTileDescription(Imf::TileDescription(2, 2));
  const std::vector<float> values(48);
  {
    Imf::TiledOutputFile out(file.path.c_str(), header);
    out.setFrameBuffer(makeFrame(values, 4, kRgb, Imf::FLOAT));
    out.writeTiles(0, 1, 0, 1);
  }
  const std::string bytes = file.read();
  expectRefused(patchAttribute(bytes, "tiles", "tiledesc", 4, 0), "tiles of 0 x 2");
  expectRefused(patchAttribute(bytes, "tiles", "tiledesc", 8, -1), "tiles of 2 x 4294967295");
}

// Reads damaged bytes: an InputError or a picture of plausible size are fine, anything else is not.
void expectNoHarm(const ScratchFile& file, const std::string& bytes) {
  file.write(bytes);
  try {
    const Image image = readExr(file.path);
    EXPECT_EQ(image.rgb.size(), 3 * image.window.area());
  } catch (const InputError&) {
  }
}

TEST(Exr, AFileCutShortAnywhereIsRefused) {
  const ScratchFile file;
  const std::string bytes = encodeExr(makePattern(40, 33), {.strings = {{"scene", "x"}}});
  // Every length in the header and the table of contents, then every 7th.
  for (size_t length = 0; length < bytes.size(); length += length < 500 ? 1 : 7) {
    file.write(bytes.substr(0, length));
    EXPECT_NE(refusalOf(file.path), "no error") << length << " of " << bytes.size();
  }
  file.write(bytes.substr(0, bytes.size() - 1));
  EXPECT_NE(refusalOf(file.path), "no error");
}

TEST(Exr, RandomDamageDoesNoHarm) {
  const ScratchFile file;
  const std::string bytes = encodeExr(makePattern(40, 33), {.strings = {{"scene", "x"}}});
  std::mt19937 random(7);
  for (int round = 0; round < 500; ++round) {
    std::string damaged = bytes;
    // Every other round hits the header and the table of contents only.
    const size_t reach = round % 2 == 0 ? damaged.size() : 500;
    for (unsigned flips = 1 + unsigned(random()) % 4; flips > 0; --flips) {
      damaged[random() % reach] ^= char(1 + random() % 255);
    }
    SCOPED_TRACE(round);
    expectNoHarm(file, damaged);
  }
}

TEST(Exr, RandomDamageToATiledFileDoesNoHarm) {
  const ScratchFile file;
  const Image image = makePattern(20, 20);
  Imf::Header header = makeHeader(20, 20, kRgb, Imf::FLOAT);
  header.setTileDescription(Imf::TileDescription(8, 8));
  {
    Imf::TiledOutputFile out(file.path.c_str(), header);
    out.setFrameBuffer(makeFrame(image.rgb, 20, kRgb, Imf::FLOAT));
    out.writeTiles(0, 2, 0, 2);
  }
  const std::string bytes = file.read();
  std::mt19937 random(11);
  for (int round = 0; round < 200; ++round) {
    std::string damaged = bytes;
    damaged[random() % (round % 2 == 0 ? damaged.size() : 450)] ^= char(1 + random() % 255);
    SCOPED_TRACE(round);
    expectNoHarm(file, damaged);
  }
}

}  // namespace
}  // namespace turner
