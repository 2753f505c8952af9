// Apollo's NDT maps: config.xml, and nodes of two by two cells, plain and packed. The first byte
// decides which; the rest is the file.

#include "formats/foreign/maps/apollo_files.h"
#include "tests/fuzz/fuzz.h"

namespace sightline {
namespace {

void read_config(const FuzzInput& input) {
  const std::string_view text(reinterpret_cast<const char*>(input.bytes().data()),
                              input.bytes().size());
  const Result<ApolloConfig> config = parse_apollo_config(text, "config.xml");
  if (!config) return check_refusal(config.error());
  SIGHTLINE_CHECK(config->node_columns > 0 && config->node_rows > 0);
  SIGHTLINE_CHECK(!config->cells_m.empty());
  SIGHTLINE_CHECK(config->cells_m.size() == config->heights_m.size());
}

void read_node(const FuzzInput& input, bool is_compressed) {
  ApolloConfig config;
  config.node_columns = config.node_rows = 2;
  config.is_compressed = is_compressed;
  config.cells_m = config.heights_m = {1.0};
  const ApolloNodeIndex index{0, 10, 1, 1};
  const Result<ApolloNode> node = parse_apollo_node(input.bytes(), config, index, "node");
  if (!node) return check_refusal(node.error());
  for (const ForeignNd& nd : node->nds) {
    SIGHTLINE_CHECK(nd.point_count >= 2 && nd.covariance_m2.allFinite());
    SIGHTLINE_CHECK(nd.mean_in_cell_m.minCoeff() >= 0.0 && nd.mean_in_cell_m.maxCoeff() < 1.0);
    // A mean outside its column by at most two cells.
    SIGHTLINE_CHECK(nd.key_world.x >= 0 && nd.key_world.x <= 5);
    SIGHTLINE_CHECK(nd.key_world.y >= 0 && nd.key_world.y <= 5);
  }
}

}  // namespace
}  // namespace sightline

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  if (size == 0) return 0;
  const FuzzInput input(data + 1, size - 1);
  switch (data[0] % 3) {
    case 0:
      read_config(input);
      break;
    case 1:
      read_node(input, /*is_compressed=*/false);
      break;
    default:
      read_node(input, /*is_compressed=*/true);
  }
  return 0;
}
