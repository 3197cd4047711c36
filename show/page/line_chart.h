#pragma once

#include <string>
#include <vector>

#include "show/page/page.h"

namespace pleat::show {

// Places for about `count` ticks within [low, high], at 1, 2 or 5 times a power of ten. low < high,
// both finite.
std::vector<double> tick_values(double low, double high, int count);

std::string line_chart_html(const LineChart& chart);  // a <figure> with inline SVG and a legend

}  // namespace pleat::show
