#include "show/image.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/error.h"
#include "core/provenance.h"

namespace pleat::show {
namespace {

void set_pixel(Image& image, size_t pixel, const Color& color) {
  for (int c = 0; c < 3; ++c) {
    image.rgb[3 * pixel + c] = uint8_t(std::lround(255 * std::clamp(color[c], 0.0, 1.0)));
  }
}

void require_pixels(const Image& image) {
  if (image.width <= 0 || image.height <= 0 ||
      image.rgb.size() != size_t(3) * image.width * image.height) {
    throw InputError("image of " + std::to_string(image.width) + " x " +
                     std::to_string(image.height) + " pixels holds " +
                     std::to_string(image.rgb.size()) +
                     " bytes; expected 3 a pixel, at least one pixel");
  }
}

}  // namespace

Image blank_image(int width, int height, const Color& color) {
  Image image{width, height, std::vector<uint8_t>(size_t(3) * width * height)};
  for (size_t pixel = 0; pixel < size_t(width) * height; ++pixel) set_pixel(image, pixel, color);
  return image;
}

std::string png_bytes(const Image& image) {
  require_pixels(image);
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = png_uint_32(image.width);
  header.height = png_uint_32(image.height);
  header.format = PNG_FORMAT_RGB;
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(header), '\0');
  png_alloc_size_t size = bytes.size();
  if (!png_image_write_to_memory(&header, bytes.data(), &size, 0, image.rgb.data(), 0, nullptr)) {
    throw std::runtime_error(std::string("PNG: ") + header.message);
  }
  bytes.resize(size);
  bytes.shrink_to_fit();
  return bytes;
}

void write_png(const std::string& path, const Image& image) {
  write_file_atomically(path, png_bytes(image));
}

Image contact_sheet(const std::vector<Image>& images, int columns, int gap,
                    const Color& background) {
  if (images.empty() || columns < 1 || gap < 0) {
    throw InputError("contact sheet of " + std::to_string(images.size()) + " images, " +
                     std::to_string(columns) + " columns, gap " + std::to_string(gap) +
                     "; expected at least one image and one column, gap 0 or more");
  }
  int width = 0, height = 0;
  for (const Image& image : images) {
    require_pixels(image);
    width = std::max(width, image.width);
    height = std::max(height, image.height);
  }
  const int count = int(images.size());
  columns = std::min(columns, count);
  const int rows = (count + columns - 1) / columns;
  Image sheet = blank_image(columns * (width + gap) - gap, rows * (height + gap) - gap, background);
  for (int i = 0; i < count; ++i) {
    const Image& image = images[i];
    const int left = (i % columns) * (width + gap) + (width - image.width) / 2;
    const int top = (i / columns) * (height + gap) + (height - image.height) / 2;
    for (int y = 0; y < image.height; ++y) {
      std::copy_n(image.rgb.begin() + size_t(3) * y * image.width, size_t(3) * image.width,
                  sheet.rgb.begin() + 3 * (size_t(top + y) * sheet.width + left));
    }
  }
  return sheet;
}

Image texture_image(const std::vector<float>& offsets, int resolution, double scale_m) {
  const size_t texels = size_t(std::max(resolution, 0)) * std::max(resolution, 0);
  if (texels == 0 || offsets.size() != 3 * texels || !(scale_m > 0)) {
    throw InputError("texture of " + std::to_string(offsets.size()) + " numbers, resolution " +
                     std::to_string(resolution) + ", scale " + std::to_string(scale_m) +
                     " m; expected 3 x resolution x resolution numbers and a scale > 0");
  }
  Image image = blank_image(resolution, resolution, kNotFiniteColor);
  for (size_t texel = 0; texel < texels; ++texel) {
    const Vec<3> offset(offsets[texel], offsets[texels + texel], offsets[2 * texels + texel]);
    if (!offset.allFinite()) continue;
    for (int c = 0; c < 3; ++c) {
      image.rgb[3 * texel + c] =
          uint8_t(128 + std::lround(127 * std::clamp(offset[c] / scale_m, -1.0, 1.0)));
    }
  }
  return image;
}

}  // namespace pleat::show
