#include "formats/picture/calibration_picture.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "formats/text_grid.h"

namespace sightline {
namespace {

constexpr double kSide = 400.0;    // of the square that shares are drawn in
constexpr double kMargin = 50.0;   // for the numbers beside it
constexpr double kMostArea = 120.0;  // of a point
constexpr const char* kColours[] = {"#1f5fa8", "#c2571a", "#2f7d3b", "#7a3f9d"};

std::string x_of(double share) { return fixed(kMargin + kSide * share, 1); }
std::string y_of(double share) { return fixed(kMargin + kSide * (1.0 - share), 1); }

std::string line(double from_x, double from_y, double to_x, double to_y,
                 const std::string& colour) {
  return "<line x1=\"" + x_of(from_x) + "\" y1=\"" + y_of(from_y) + "\" x2=\"" + x_of(to_x) +
         "\" y2=\"" + y_of(to_y) + "\" stroke=\"" + colour + "\"/>\n";
}

std::string label(const std::string& x, const std::string& y, const std::string& words,
                  const std::string& attributes = "") {
  return "<text x=\"" + x + "\" y=\"" + y + "\" " + attributes + ">" + words + "</text>\n";
}

std::string axes() {
  std::string text;
  for (int tenth = 0; tenth <= 10; tenth += 2) {
    const double share = 0.1 * tenth;
    text += line(share, 0.0, share, 1.0, "#dddddd") + line(0.0, share, 1.0, share, "#dddddd");
    text += label(x_of(share), fixed(kMargin + kSide + 18.0, 1), fixed(share, 1),
                  "text-anchor=\"middle\"");
    text += label(fixed(kMargin - 8.0, 1), y_of(share), fixed(share, 1), "text-anchor=\"end\"");
  }
  text += label(x_of(0.5), fixed(kMargin + kSide + 38.0, 1), "promised", "text-anchor=\"middle\"");
  text += label(fixed(kMargin, 1), fixed(kMargin - 14.0, 1), "observed", "text-anchor=\"middle\"");
  return text + line(0.0, 0.0, 1.0, 1.0, "#888888");
}

std::string curve(const std::vector<ReliabilityBin>& bins, const std::string& colour) {
  std::uint32_t most = 1;
  for (const ReliabilityBin& bin : bins) most = std::max(most, bin.count);
  std::string points;
  std::string dots;
  for (const ReliabilityBin& bin : bins) {
    const double radius = std::sqrt(kMostArea * bin.count / most);
    points += x_of(bin.promised) + "," + y_of(bin.observed) + " ";
    dots += "<circle cx=\"" + x_of(bin.promised) + "\" cy=\"" + y_of(bin.observed) + "\" r=\"" +
            fixed(radius, 1) + "\" fill=\"" + colour + "\"><title>" + std::to_string(bin.count) +
            " pairs</title></circle>\n";
  }
  return "<polyline points=\"" + points + "\" fill=\"none\" stroke=\"" + colour + "\"/>\n" + dots;
}

}  // namespace

std::string calibration_picture_svg(const Evaluation& evaluation) {
  const std::string side = fixed(kSide + 2.0 * kMargin, 0);
  std::string text = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + side + " " + side +
                     "\" font-family=\"sans-serif\" font-size=\"12\">\n"
                     "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n" +
                     axes();
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    const std::string colour = kColours[limit % std::size(kColours)];
    std::vector<ReliabilityBin> bins;
    std::ranges::copy_if(evaluation.reliability, std::back_inserter(bins),
                         [&](const ReliabilityBin& bin) {
                           return bin.limit_m == evaluation.limits_m[limit];
                         });
    text += curve(bins, colour);
    text += label(x_of(0.03), y_of(0.95 - 0.05 * static_cast<double>(limit)),
                  fixed(100.0 * evaluation.limits_m[limit], 0) + " cm", "fill=\"" + colour + "\"");
  }
  return text + "</svg>\n";
}

}  // namespace sightline
