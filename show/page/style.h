#pragma once

namespace pleat::show {

extern const char* const kPageStyle;  // CSS

}  // namespace pleat::show
