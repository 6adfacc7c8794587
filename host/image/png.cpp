// In: a picture in linear light. Out: the bytes of an 8-bit sRGB PNG file.
// libpng reports failures by longjmp, which skips destructors: the functions it may leave (writeAll, and the callbacks
// below) therefore hold no object that has one, and no C++ exception crosses libpng.
#include "image/png.h"

#include <png.h>

#include <cassert>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <vector>

#include "base/errors.h"

namespace turner {
namespace {

// Stated, so that the bytes do not follow zlib's defaults.
constexpr int kZlibLevel = 6;

struct Sink {
  std::string* bytes = nullptr;
  char fault[200] = "unknown failure";
};

// The sRGB transfer function, IEC 61966-2-1, from linear light in [0, 1] to the encoded value in [0, 1].
double encodeSrgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

// NaN fails both comparisons and so becomes 0.
png_byte quantize(float linear) {
  if (!(linear > 0)) return 0;
  if (linear >= 1) return 255;
  return png_byte(std::lround(255 * encodeSrgb(linear)));
}

[[noreturn]] void onError(png_structp png, png_const_charp message) {
  std::snprintf(static_cast<Sink*>(png_get_error_ptr(png))->fault, sizeof Sink::fault, "%s", message);
  png_longjmp(png, 1);
}

void onWarning(png_structp, png_const_charp) {}

bool append(std::string& bytes, const png_byte* data, size_t size) {
  try {
    bytes.append(reinterpret_cast<const char*>(data), size);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

void onWrite(png_structp png, png_bytep data, size_t size) {
  if (!append(*static_cast<Sink*>(png_get_io_ptr(png))->bytes, data, size)) png_error(png, "out of memory");
}

void onFlush(png_structp) {}

// Writes the whole file into the sink; returns false with the reason in sink.fault.
bool writeAll(Sink& sink, const png_byte* pixels, int width, int height) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &sink, onError, onWarning);
  if (!png) return false;
  // Set once here, before setjmp, and never after it: its value after a longjmp is defined.
  png_infop info = png_create_info_struct(png);
  if (!info || setjmp(png_jmpbuf(png))) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, &sink, onWrite, onFlush);
  png_set_compression_level(png, kZlibLevel);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_ALL_FILTERS);
  png_set_IHDR(png, info, png_uint_32(width), png_uint_32(height), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  // Beside sRGB this writes the gamma and chromaticities that readers without sRGB fall back on.
  png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(png, info);
  for (int y = 0; y < height; ++y) png_write_row(png, pixels + 3 * size_t(width) * size_t(y));
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return true;
}

}  // namespace

std::string encodePng(const Image& image) {
  assert(image.rgb.size() == 3 * image.window.area());
  std::vector<png_byte> pixels(image.rgb.size());
  for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = quantize(image.rgb[i]);
  std::string bytes;
  Sink sink{.bytes = &bytes};
  if (!writeAll(sink, pixels.data(), image.window.width(), image.window.height())) {
    throw RunError(std::string("libpng cannot encode the picture: ") + sink.fault);
  }
  return bytes;
}

}  // namespace turner
