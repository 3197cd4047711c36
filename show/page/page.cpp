#include "show/page/page.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "show/page/html_text.h"
#include "show/page/line_chart.h"
#include "show/page/style.h"

namespace pleat::show {
namespace {

std::string css_color(const Color& color) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", int(std::lround(255 * color[0])),
                int(std::lround(255 * color[1])), int(std::lround(255 * color[2])));
  return text;
}

void write_facts(std::ostream& out, const std::vector<Fact>& facts, const char* style) {
  out << "<dl class=\"" << style << "\">";
  for (const Fact& fact : facts) {
    out << "<div><dt>" << escape_html(fact.name) << "</dt><dd>" << escape_html(fact.value)
        << "</dd></div>";
  }
  out << "</dl>\n";
}

void write(std::ostream& out, const Paragraph& paragraph) {
  out << "<p>" << escape_html(paragraph.text) << "</p>\n";
}

void write(std::ostream& out, const Headline& headline) {
  write_facts(out, headline.facts, "headline");
}

void write(std::ostream& out, const FactList& list) { write_facts(out, list.facts, "facts"); }

void write(std::ostream& out, const Table& table) {
  const auto style = [&](size_t column) {
    return table.columns[column].is_number ? " class=\"number\"" : "";
  };
  out << "<figure>";
  if (!table.caption.empty()) {  // outside of what scrolls sideways
    out << "<figcaption class=\"above\">" << escape_html(table.caption) << "</figcaption>";
  }
  out << "<div class=\"scroll\"><table>";
  out << "<thead><tr>";
  for (size_t c = 0; c < table.columns.size(); ++c) {
    const Column& column = table.columns[c];
    out << "<th scope=\"col\"" << style(c) << ">" << escape_html(column.name);
    if (!column.unit.empty()) out << "<small>" << escape_html(column.unit) << "</small>";
    out << "</th>";
  }
  out << "</tr></thead><tbody>\n";
  for (const std::vector<std::string>& row : table.rows) {
    out << "<tr>";
    for (size_t c = 0; c < table.columns.size(); ++c) {
      out << "<td" << style(c) << ">" << (c < row.size() ? escape_html(row[c]) : "\u2013")
          << "</td>";
    }
    out << "</tr>\n";
  }
  out << "</tbody></table></div></figure>\n";
}

void write(std::ostream& out, const ColorBar& bar) {
  constexpr int kSteps = 32;
  out << "<div class=\"colorbar\"><span>" << escape_html(bar.label) << "</span><span>"
      << escape_html(bar.low) << "</span><svg viewBox=\"0 0 " << kSteps
      << " 1\" preserveAspectRatio=\"none\" shape-rendering=\"crispEdges\" aria-hidden=\"true\">";
  for (int i = 0; i < kSteps; ++i) {
    out << "<rect x=\"" << i << "\" width=\"1\" height=\"1\" fill=\""
        << css_color(heat_color((i + 0.5) / kSteps)) << "\"/>";
  }
  out << "</svg><span>" << escape_html(bar.high) << "</span></div>";
}

void write(std::ostream& out, const Picture& picture, const std::string& description) {
  if (picture.png.empty()) {
    out << "<figure class=\"missing\"><figcaption>"
        << (picture.caption.empty() ? "no picture" : escape_html(picture.caption))
        << "</figcaption></figure>";
    return;
  }
  out << "<figure><img alt=\"" << escape_html(description) << "\" src=\"data:image/png;base64,"
      << base64(picture.png) << "\">";
  if (!picture.caption.empty()) {
    out << "<figcaption>" << escape_html(picture.caption) << "</figcaption>";
  }
  out << "</figure>\n";
}

void write(std::ostream& out, const PictureGrid& grid) {
  size_t columns = grid.column_titles.size();
  for (const PictureRow& row : grid.rows) columns = std::max(columns, row.pictures.size());
  if (columns == 0) return;
  const std::string most = format_number(grid.picture_width_rem);
  out << "<figure" << (grid.is_pixelated ? " class=\"pixelated\"" : "")
      << "><div class=\"pictures\"><div class=\"grid\" style=\"grid-template-columns:repeat("
      << columns << ",minmax(5.5rem," << most << "rem))\">";
  for (const std::string& title : grid.column_titles) {
    out << "<div class=\"column\">" << escape_html(title) << "</div>";
  }
  for (size_t c = grid.column_titles.size(); c < columns && !grid.column_titles.empty(); ++c) {
    out << "<div class=\"column\"></div>";
  }
  for (const PictureRow& row : grid.rows) {
    if (!row.title.empty()) out << "<div class=\"row\">" << escape_html(row.title) << "</div>\n";
    for (size_t c = 0; c < columns; ++c) {
      if (c >= row.pictures.size()) {
        out << "<div></div>";
        continue;
      }
      std::string description = row.title;
      for (const std::string& part :
           {c < grid.column_titles.size() ? grid.column_titles[c] : "", row.pictures[c].caption}) {
        if (!part.empty()) description += (description.empty() ? "" : ", ") + part;
      }
      write(out, row.pictures[c], description);
    }
  }
  out << "</div></div>";
  if (grid.color_bar) write(out, *grid.color_bar);
  if (!grid.caption.empty()) out << "<figcaption>" << escape_html(grid.caption) << "</figcaption>";
  out << "</figure>\n";
}

void write(std::ostream& out, const LineChart& chart) { out << line_chart_html(chart); }

void write(std::ostream& out, const Details& details) {
  out << "<details><summary>" << escape_html(details.title) << "</summary><pre>"
      << escape_html(details.text) << "</pre></details>\n";
}

void write(std::ostream& out, const std::vector<Block>& blocks) {
  bool is_in_charts = false;
  for (const Block& block : blocks) {
    const bool is_chart = std::holds_alternative<LineChart>(block);
    if (is_chart != is_in_charts) out << (is_chart ? "<div class=\"charts\">\n" : "</div>\n");
    is_in_charts = is_chart;
    std::visit([&](const auto& content) { write(out, content); }, block);
  }
  if (is_in_charts) out << "</div>\n";
}

}  // namespace

std::string html(const Page& page) {
  std::ostringstream out;
  out << "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         // The page can load nothing and run nothing, whatever a name in it may contain.
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
         "style-src 'unsafe-inline'; img-src data:\">\n<title>"
      << escape_html(page.title) << "</title>\n<style>" << kPageStyle
      << "</style>\n</head>\n<body>\n"
      << "<header><h1>" << escape_html(page.title) << "</h1>\n";
  if (!page.subtitle.empty()) {
    out << "<p class=\"subtitle\">" << escape_html(page.subtitle) << "</p>\n";
  }
  if (page.sections.size() > 1) {
    out << "<nav>";
    for (size_t i = 0; i < page.sections.size(); ++i) {
      out << "<a href=\"#section-" << i + 1 << "\">" << escape_html(page.sections[i].title)
          << "</a>\n";
    }
    out << "</nav>";
  }
  out << "</header>\n<main>\n";
  for (size_t i = 0; i < page.sections.size(); ++i) {
    out << "<section id=\"section-" << i + 1 << "\">\n<h2>" << escape_html(page.sections[i].title)
        << "</h2>\n";
    write(out, page.sections[i].blocks);
    out << "</section>\n";
  }
  out << "</main>\n<footer>";
  if (!page.footer.empty()) write_facts(out, page.footer, "facts");
  out << "</footer>\n</body>\n</html>\n";
  return out.str();
}

void write_page(const std::string& path, const Page& page) {
  write_file_atomically(path, html(page));
}

Picture picture(const Image& image, const std::string& caption) {
  return {png_bytes(image), caption};
}

std::vector<Fact> provenance_facts(const Provenance& provenance) {
  std::vector<Fact> facts = {{"Made by", "pleat " + version() + ", commit " + commit()},
                             {"Stage", provenance.stage},
                             {"Seed", std::to_string(provenance.seed)},
                             {"Machine", machine()}};
  for (const auto& [role, sha256] : provenance.inputs) {
    facts.push_back({"Input " + role, "sha256 " + sha256});
  }
  return facts;
}

std::string format_number(double value, int digits) {
  if (!std::isfinite(value)) return "\u2013";
  char text[48];
  std::snprintf(text, sizeof text, "%.*g", std::clamp(digits, 1, 17), value == 0 ? 0.0 : value);
  return text;
}

}  // namespace pleat::show
