// 8-bit RGB pictures: PNG, contact sheets, offset textures as pictures.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "show/color.h"

namespace pleat::show {

struct Image {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> rgb;  // height x width x 3, sRGB, top row first
};

Image blank_image(int width, int height, const Color& color);

std::string png_bytes(const Image& image);                    // the content of a .png file
void write_png(const std::string& path, const Image& image);  // written whole or not at all

// The images row by row, `columns` to a row, each in the middle of a cell as large as the largest
// of them, with gaps of `gap` pixels between cells. Throws InputError where there is none.
Image contact_sheet(const std::vector<Image>& images, int columns, int gap = 8,
                    const Color& background = Color(1, 1, 1));

// An offset texture as the paper shows it: offsets x, y, z as red, green, blue; grey is 0, -scale_m
// black, +scale_m full. `offsets`: [3, resolution, resolution], m, top row first. Not finite is
// kNotFiniteColor.
Image texture_image(const std::vector<float>& offsets, int resolution, double scale_m);

}  // namespace pleat::show
