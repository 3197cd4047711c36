// A page of results as one HTML file that opens offline: no script, no link, pictures inside. Light
// and dark, wide and narrow, screen and paper. Every string below is text: what it means in HTML is
// escaped.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/provenance.h"
#include "show/image.h"

namespace pleat::show {

struct Paragraph {
  std::string text;
};

struct Fact {
  std::string name, value;
};
struct Headline {  // the few numbers to see first, large
  std::vector<Fact> facts;
};
struct FactList {  // name and value, one below the other
  std::vector<Fact> facts;
};

struct Column {
  std::string name;
  std::string unit;       // empty for none
  bool is_number = true;  // numbers stand to the right
};
struct Table {
  std::string caption;
  std::vector<Column> columns;
  std::vector<std::vector<std::string>> rows;  // a missing cell is shown as a dash
};

struct Picture {
  std::string png;  // bytes of the file; empty: the caption stands in a frame alone
  std::string caption;
};
struct ColorBar {  // the scale of heat_color
  std::string label;
  std::string low, high;  // "0", "5 mm"
};
struct PictureRow {
  std::string title;
  std::vector<Picture> pictures;
};
struct PictureGrid {
  std::string caption;
  std::vector<std::string> column_titles;
  std::vector<PictureRow> rows;
  std::optional<ColorBar> color_bar;
  bool is_pixelated = false;      // texels stay square when enlarged
  double picture_width_rem = 19;  // at most; pictures shrink together on narrow screens
};

struct Series {
  std::string name;
  std::vector<double> x, y;  // of equal length; points that are not finite leave a gap
};
struct LineChart {  // charts that follow each other stand side by side
  std::string caption;
  std::string x_label, y_label;  // with unit: "frame", "error (mm)"
  std::vector<Series> series;    // at most 6 have their own colour
  bool has_log_y = false;        // values <= 0 leave a gap
};

struct Details {  // folded until opened
  std::string title;
  std::string text;  // monospace, line breaks kept
};

using Block = std::variant<Paragraph, Headline, FactList, Table, PictureGrid, LineChart, Details>;

struct Section {
  std::string title;
  std::vector<Block> blocks;
};

struct Page {
  std::string title;
  std::string subtitle;
  std::vector<Section> sections;
  std::vector<Fact> footer;
};

std::string html(const Page& page);

void write_page(const std::string& path, const Page& page);  // written whole or not at all

Picture picture(const Image& image, const std::string& caption = "");

// Stage, version, commit, seed, inputs and machine, for a footer or a FactList.
std::vector<Fact> provenance_facts(const Provenance& provenance);

// Shortest plain text of so many significant digits: 0.0123, 1.5e+07; a dash for what is not
// finite.
std::string format_number(double value, int digits = 3);

}  // namespace pleat::show
