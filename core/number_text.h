// Numbers as text.
#pragma once

#include <string>

namespace pleat {

// The shortest that reads back as the same number: different for different numbers.
std::string shortest_text(double number);

}  // namespace pleat
