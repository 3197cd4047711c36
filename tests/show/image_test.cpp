#include "show/image.h"

#include <gtest/gtest.h>
#include <png.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "core/error.h"

namespace pleat::show {
namespace {

Image decode_png(const std::string& bytes) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&header, bytes.data(), bytes.size())) return {};
  header.format = PNG_FORMAT_RGB;
  Image image{int(header.width), int(header.height), std::vector<uint8_t>(PNG_IMAGE_SIZE(header))};
  png_image_finish_read(&header, nullptr, image.rgb.data(), 0, nullptr);
  return image;
}

std::array<int, 3> pixel(const Image& image, int x, int y) {
  const uint8_t* rgb = &image.rgb[3 * (size_t(y) * image.width + x)];
  return {rgb[0], rgb[1], rgb[2]};
}

TEST(Png, DecodesToTheSamePixels) {
  Image image{37, 11, {}};
  for (int i = 0; i < 3 * 37 * 11; ++i) image.rgb.push_back(uint8_t(i * i * 7 + i));
  const Image decoded = decode_png(png_bytes(image));
  EXPECT_EQ(decoded.width, 37);
  EXPECT_EQ(decoded.height, 11);
  EXPECT_EQ(decoded.rgb, image.rgb);
}

TEST(Png, FileHoldsTheSameBytes) {
  const Image image = blank_image(5, 4, Color(0.2, 0.4, 0.6));
  const auto path = std::filesystem::temp_directory_path() /
                    ("pleat_image_test_" + std::to_string(::getpid()) + ".png");
  write_png(path, image);
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  EXPECT_EQ(bytes, png_bytes(image));
  std::filesystem::remove(path);
}

TEST(Png, RefusesAnImageThatLacksPixels) {
  EXPECT_THROW(png_bytes(Image{}), InputError);
  EXPECT_THROW(png_bytes(Image{2, 2, std::vector<uint8_t>(11)}), InputError);
}

TEST(ContactSheet, PutsImagesRowByRowInTheMiddleOfEqualCells) {
  const Color white(1, 1, 1);
  const std::vector<Image> images = {blank_image(4, 6, Color(1, 0, 0)),
                                     blank_image(2, 2, Color(0, 1, 0)),
                                     blank_image(4, 6, Color(0, 0, 1))};
  const Image sheet = contact_sheet(images, 2, 3, white);
  EXPECT_EQ(sheet.width, 4 + 3 + 4);
  EXPECT_EQ(sheet.height, 6 + 3 + 6);
  EXPECT_EQ(pixel(sheet, 0, 0), (std::array<int, 3>{255, 0, 0}));
  EXPECT_EQ(pixel(sheet, 3, 5), (std::array<int, 3>{255, 0, 0}));
  EXPECT_EQ(pixel(sheet, 4, 0), (std::array<int, 3>{255, 255, 255}));  // gap
  EXPECT_EQ(pixel(sheet, 7, 0), (std::array<int, 3>{255, 255, 255}));  // around the small one
  EXPECT_EQ(pixel(sheet, 8, 2), (std::array<int, 3>{0, 255, 0}));
  EXPECT_EQ(pixel(sheet, 9, 3), (std::array<int, 3>{0, 255, 0}));
  EXPECT_EQ(pixel(sheet, 10, 3), (std::array<int, 3>{255, 255, 255}));
  EXPECT_EQ(pixel(sheet, 0, 9), (std::array<int, 3>{0, 0, 255}));
  EXPECT_EQ(pixel(sheet, 8, 12), (std::array<int, 3>{255, 255, 255}));  // empty cell
}

TEST(ContactSheet, IsNoWiderThanItsImages) {
  EXPECT_EQ(contact_sheet({blank_image(4, 4, Color(0, 0, 0))}, 5).width, 4);
  EXPECT_THROW(contact_sheet({}, 2), InputError);
}

TEST(TextureImage, ShowsZeroAsGreyAndAxesAsChannels) {
  // 2 x 2 texels: nothing; +x full; -y full; beyond the scale along z.
  const std::vector<float> offsets = {0, 0.02F, 0, 0, 0, 0, -0.02F, 0, 0, 0, 0, 0.5F};
  const Image image = texture_image(offsets, 2, 0.02);
  EXPECT_EQ(pixel(image, 0, 0), (std::array<int, 3>{128, 128, 128}));
  EXPECT_EQ(pixel(image, 1, 0), (std::array<int, 3>{255, 128, 128}));
  EXPECT_EQ(pixel(image, 0, 1), (std::array<int, 3>{128, 1, 128}));
  EXPECT_EQ(pixel(image, 1, 1), (std::array<int, 3>{128, 128, 255}));
}

TEST(TextureImage, MarksWhatIsNotFiniteAndRefusesOtherSizes) {
  const Image image = texture_image({0, std::numeric_limits<float>::quiet_NaN(), 0}, 1, 0.02);
  EXPECT_EQ(pixel(image, 0, 0), (std::array<int, 3>{255, 0, 255}));
  EXPECT_THROW(texture_image({0, 0, 0, 0}, 1, 0.02), InputError);
  EXPECT_THROW(texture_image({0, 0, 0}, 1, 0), InputError);
}

}  // namespace
}  // namespace pleat::show
