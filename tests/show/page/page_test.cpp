#include "show/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "show/page/html_text.h"

namespace pleat::show {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Every kind of block, with hostile text in every string.
Page page_saying(const std::string& text) {
  const Image image = blank_image(4, 4, kSimulatedColor);
  Page page;
  page.title = page.subtitle = text;
  PictureGrid grid;
  grid.caption = text;
  grid.column_titles = {text, text};
  grid.rows = {{text, {picture(image, text), {"", text}}}};
  grid.color_bar = ColorBar{text, text, text};
  LineChart chart;
  chart.caption = chart.x_label = chart.y_label = text;
  chart.series = {{text, {0, 1}, {1, 2}}, {text, {0, 1}, {2, 1}}};
  page.sections = {{text,
                    {Paragraph{text}, Headline{{{text, text}}}, FactList{{{text, text}}},
                     Table{text, {{text, text, true}, {text, "", false}}, {{text, text}, {text}}},
                     grid, chart, chart, Details{text, text}}},
                   {text, {}}};
  page.footer = {{text, text}};
  return page;
}

TEST(Page, EscapesEveryString) {
  const std::string page = html(page_saying("<script>alert(\"1\")</script> ' onload='x"));
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, Not(HasSubstr("' onload='")));
  EXPECT_THAT(page, HasSubstr("&lt;script&gt;alert(&quot;1&quot;)&lt;/script&gt;"));
}

TEST(Page, ShowsEveryString) {
  // Strings of page_saying: 2 of the page twice for the title, 2 a section title with the
  // navigation, blocks, footer.
  const std::string page = html(page_saying("qqq"));
  int found = 0;
  for (size_t at = page.find("qqq"); at != std::string::npos; at = page.find("qqq", at + 1))
    ++found;
  const int page_level = 3 + 2 * 2 + 2;
  const int text_blocks = 1 + 2 + 2 + 2;
  const int table = 1 + 3 + 3;
  const int grid =
      1 + 2 + 1 + 2 + 3 + 3;  // caption, columns, row, picture captions, description, colour bar
  const int charts =
      2 * (1 + 4 + 4);  // caption; two labels twice, aria; names in lines and in the legend
  EXPECT_EQ(found, page_level + text_blocks + table + grid + charts);
}

TEST(Page, LoadsNothingFromElsewhere) {
  const std::string page = html(page_saying("text"));
  for (const char* link :
       {"http://", "https://", "<link", "@import", "url(", "<script", "<iframe"}) {
    EXPECT_THAT(page, Not(HasSubstr(link)));
  }
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
}

TEST(Page, HoldsItsPictures) {
  const Image image = blank_image(4, 4, kSimulatedColor);
  EXPECT_THAT(html(page_saying("text")),
              HasSubstr("src=\"data:image/png;base64," + base64(png_bytes(image)) + "\""));
}

TEST(Page, ClosesEveryElement) {
  const std::string page = html(page_saying("text"));
  for (const std::string name :
       {"section", "div",    "figure", "figcaption", "table", "tr",      "td",  "th", "svg",
        "ul",      "li",     "dl",     "dt",         "dd",    "details", "pre", "p",  "main",
        "footer",  "header", "nav",    "text",       "path",  "span",    "a"}) {
    int depth = 0, opened = 0;
    for (size_t at = page.find('<'); at != std::string::npos; at = page.find('<', at + 1)) {
      const auto is_tag = [&](const std::string& start) {
        return page.compare(at, start.size(), start) == 0 &&
               (page[at + start.size()] == '>' || page[at + start.size()] == ' ');
      };
      if (is_tag("<" + name)) ++depth, ++opened;
      if (is_tag("</" + name)) --depth;
      ASSERT_GE(depth, 0) << name;
    }
    EXPECT_EQ(depth, 0) << name;
    EXPECT_GT(opened, 0) << name;
  }
}

TEST(Page, WritesTheSameBytes) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("pleat_page_test_" + std::to_string(::getpid()) + ".html");
  const Page page = page_saying("text");
  write_page(path, page);
  std::ifstream file(path, std::ios::binary);
  EXPECT_EQ(std::string((std::istreambuf_iterator<char>(file)), {}), html(page));
  std::filesystem::remove(path);
}

TEST(EscapeHtml, DropsControlCharactersAndKeepsText) {
  EXPECT_EQ(escape_html(std::string("a\0b\x1b[1m\nc\té", 13)), "ab[1m\nc\té");
}

TEST(Base64, MatchesTheVectorsOfRfc4648) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
}

TEST(FormatNumber, IsShort) {
  EXPECT_EQ(format_number(0.012345), "0.0123");
  EXPECT_EQ(format_number(12.0), "12");
  EXPECT_EQ(format_number(-0.0), "0");
  EXPECT_EQ(format_number(std::numeric_limits<double>::quiet_NaN()), "\u2013");
}

TEST(ProvenanceFacts, NameInputsAndSeed) {
  Provenance provenance;
  provenance.stage = "encode";
  provenance.seed = 42;
  provenance.inputs = {{"body", "abc"}};
  std::string text;
  for (const Fact& fact : provenance_facts(provenance)) text += fact.name + "=" + fact.value + ";";
  EXPECT_THAT(text, HasSubstr("Seed=42;"));
  EXPECT_THAT(text, HasSubstr("Input body=sha256 abc;"));
}

}  // namespace
}  // namespace pleat::show
