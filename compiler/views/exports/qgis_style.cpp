#include "compiler/views/exports/qgis_style.h"

#include "compiler/views/picture/colours.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

// QGIS writes an option twice: as <Option> since 3.26, as <prop> before.
std::string option(const std::string& name, const std::string& value) {
  return "<Option name=\"" + name + "\" type=\"QString\" value=\"" + value + "\"/>";
}

std::string prop(const std::string& name, const std::string& value) {
  return "<prop k=\"" + name + "\" v=\"" + value + "\"/>";
}

using Values = std::vector<std::pair<std::string, std::string>>;

std::string symbol(const std::string& type, const std::string& name, const std::string& layer,
                   const Values& values) {
  std::string options;
  std::string props;
  for (const auto& [key, value] : values) {
    options += option(key, value);
    props += prop(key, value);
  }
  return "<symbol type=\"" + type + "\" name=\"" + name +
         "\" alpha=\"1\" clip_to_extent=\"1\" force_rhr=\"0\"><layer class=\"" + layer +
         "\" enabled=\"1\" locked=\"0\" pass=\"0\"><Option type=\"Map\">" + options + "</Option>" +
         props + "</layer></symbol>\n";
}

std::string rgba(const Colour& colour) {
  return std::to_string(colour.red) + "," + std::to_string(colour.green) + "," +
         std::to_string(colour.blue) + ",255";
}

std::string document(const std::string& renderer) {
  return "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
         "<qgis version=\"3.22\" styleCategories=\"Symbology\">\n" +
         renderer + "</qgis>\n";
}

}  // namespace

std::string qgis_range_style(const std::string& attribute, const std::vector<double>& ranges_m) {
  std::string categories;
  std::string symbols;
  for (std::size_t i = 0; i < ranges_m.size(); ++i) {
    const std::string range = format_double(ranges_m[i]);
    const std::string name = std::to_string(i);
    categories += "<category value=\"" + range + "\" label=\"" + range + " m\" symbol=\"" + name +
                  "\" render=\"true\"/>\n";
    symbols += symbol("marker", name, "SimpleMarker",
                      {{"name", "circle"},
                       {"color", rgba(range_colour_on_paper(i, ranges_m.size()))},
                       {"outline_style", "no"},
                       {"size", "2"},
                       {"size_unit", "MM"}});
  }
  return document("<renderer-v2 type=\"categorizedSymbol\" attr=\"" + attribute +
                  "\" symbollevels=\"0\" enableorderby=\"0\" forceraster=\"0\">\n<categories>\n" +
                  categories + "</categories>\n<symbols>\n" + symbols +
                  "</symbols>\n</renderer-v2>\n");
}

std::string qgis_line_style() {
  return document(
      "<renderer-v2 type=\"singleSymbol\" symbollevels=\"0\" enableorderby=\"0\" "
      "forceraster=\"0\">\n<symbols>\n" +
      symbol("line", "0", "SimpleLine",
             {{"line_color", "120,120,120,255"},
              {"line_style", "solid"},
              {"line_width", "0.6"},
              {"line_width_unit", "MM"},
              {"capstyle", "round"}}) +
      "</symbols>\n</renderer-v2>\n");
}

}  // namespace sightline
