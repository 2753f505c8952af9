#pragma once

#include <string_view>

// What the page is dressed with, put into the program at build (compiler/views/report/page).

namespace sightline {

std::string_view page_style();
// Of the libraries in the scripts, and the scripts themselves with their libraries; both empty
// where the program was built without npm: the page then shows still pictures.
std::string_view library_style();
std::string_view page_script();
// Draws the NDs in 3D; unpacked when its view is opened. Empty without npm.
std::string_view scene_script();

}  // namespace sightline
