#include "core/number_text.h"

#include <charconv>

namespace pleat {

std::string shortest_text(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

}  // namespace pleat
