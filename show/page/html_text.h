#pragma once

#include <string>

namespace pleat::show {

// Text as it may stand between tags and inside quoted attributes. Control characters are dropped.
std::string escape_html(const std::string& text);

std::string base64(const std::string& bytes);

}  // namespace pleat::show
