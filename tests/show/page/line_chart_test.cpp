#include "show/page/line_chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "core/error.h"

namespace pleat::show {
namespace {

using ::testing::DoubleNear;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::Pointwise;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

int count(const std::string& text, const std::string& part) {
  int found = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

std::string path_of(const std::string& html) {  // of the first series
  const size_t begin = html.find(" d=\"");
  if (begin == std::string::npos) return "";
  return html.substr(begin + 4, html.find('"', begin + 4) - begin - 4);
}

LineChart chart_of(std::vector<double> x, std::vector<double> y) {
  LineChart chart;
  chart.x_label = "frame";
  chart.y_label = "error (mm)";
  chart.series = {{"static", std::move(x), std::move(y)}};
  return chart;
}

void expect_finite_numbers(const std::string& html) {
  EXPECT_THAT(html, Not(HasSubstr("nan")));
  EXPECT_THAT(html, Not(HasSubstr("inf")));
}

TEST(TickValues, AreRoundAndInside) {
  EXPECT_THAT(tick_values(0, 10, 5), Pointwise(DoubleNear(1e-12), {0, 2, 4, 6, 8, 10}));
  EXPECT_THAT(tick_values(-0.13, 0.27, 4), Pointwise(DoubleNear(1e-12), {-0.1, 0.0, 0.1, 0.2}));
  EXPECT_THAT(tick_values(980, 1530, 5), Pointwise(DoubleNear(1e-9), {1000, 1200, 1400}));
}

TEST(LineChart, DrawsAxesTicksAndLine) {
  const std::string html = line_chart_html(chart_of({0, 5, 10}, {0, 4, 8}));
  EXPECT_THAT(html, HasSubstr(">frame</text>"));
  EXPECT_THAT(html, HasSubstr(">error (mm)</text>"));
  EXPECT_THAT(html, HasSubstr(">10</text>"));
  const std::string path = path_of(html);
  EXPECT_EQ(count(path, "M"), 1);
  EXPECT_EQ(count(path, "L"), 2);
  // The middle point lies halfway between the others.
  double x[3], y[3];
  ASSERT_EQ(std::sscanf(path.c_str(), "M%lf %lfL%lf %lfL%lf %lf", x, y, x + 1, y + 1, x + 2, y + 2),
            6);
  EXPECT_NEAR(x[1], (x[0] + x[2]) / 2, 0.1);
  EXPECT_NEAR(y[1], (y[0] + y[2]) / 2, 0.1);
  EXPECT_GT(y[0], y[2]);  // SVG counts downwards
}

TEST(LineChart, SaysSoWithoutData) {
  for (const LineChart& chart : {LineChart{}, chart_of({}, {}), chart_of({0, 1}, {kNaN, kNaN})}) {
    const std::string html = line_chart_html(chart);
    EXPECT_THAT(html, HasSubstr("no data"));
    expect_finite_numbers(html);
  }
}

TEST(LineChart, OnePointIsADot) {
  for (const double value : {0.0, 3.0, -2e-9}) {
    const std::string html = line_chart_html(chart_of({5}, {value}));
    EXPECT_EQ(count(html, "<circle"), 1);
    expect_finite_numbers(html);
  }
}

TEST(LineChart, ConstantSeriesHasAnAxis) {
  const std::string html = line_chart_html(chart_of({0, 1, 2}, {1e6, 1e6, 1e6}));
  EXPECT_GE(count(html, "gridline"), 2);
  expect_finite_numbers(html);
}

TEST(LineChart, GapsWhereValuesAreNotFinite) {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::string html =
      line_chart_html(chart_of({0, 1, 2, 3, 4, 5}, {1, 2, kNaN, 3, infinity, 5}));
  EXPECT_EQ(count(path_of(html), "M"), 3);
  EXPECT_EQ(count(html, "<circle"), 2);  // the points that stand alone
  expect_finite_numbers(html);
}

TEST(LineChart, LogAxisSkipsWhatHasNoLogarithm) {
  LineChart chart = chart_of({0, 1, 2, 3}, {1, 0, 0.01, 0.0001});
  chart.has_log_y = true;
  const std::string html = line_chart_html(chart);
  EXPECT_EQ(count(path_of(html), "M"), 2);
  EXPECT_THAT(html, HasSubstr(">0.001</text>"));
  expect_finite_numbers(html);
}

TEST(LineChart, ThinsLongSeriesButKeepsPeaks) {
  std::vector<double> x(50000), y(50000);
  for (int i = 0; i < 50000; ++i) x[i] = i, y[i] = std::sin(0.001 * i);
  y[31234] = 10;
  const std::string html = line_chart_html(chart_of(x, y));
  const std::string path = path_of(html);
  EXPECT_LT(count(path, "L"), 1700);
  // The peak reaches the top of the drawing area, where no other point comes near.
  double highest = 1e9;
  std::istringstream points(path);
  for (char command; points >> command;) {  // M or L, then x and y
    double x_here, y_here;
    ASSERT_TRUE(points >> x_here >> y_here);
    highest = std::min(highest, y_here);
  }
  EXPECT_LT(highest, 31);
}

TEST(LineChart, LegendNamesSeriesAndEscapesThem) {
  LineChart chart = chart_of({0, 1}, {0, 1});
  chart.series.push_back({"<b>temporal</b>", {0, 1}, {1, 0}});
  const std::string html = line_chart_html(chart);
  EXPECT_THAT(html, HasSubstr("&lt;b&gt;temporal"));
  EXPECT_THAT(html, Not(HasSubstr("<b>")));
  chart.series[0].x.push_back(2);
  EXPECT_THROW(line_chart_html(chart), InputError);
}

}  // namespace
}  // namespace pleat::show
