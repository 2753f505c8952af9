#include "tests/golden/step_outputs.h"

#include <algorithm>
#include <cctype>
#include <set>

#include "compiler/driver/judged_map.h"
#include "compiler/driver/pipelines.h"
#include "formats/map/map_writer.h"

namespace sightline::golden {
namespace {

// "ingest:localization" -> "kIngestVersion".
std::string version_constant(const std::string& step) {
  std::string constant = "k";
  bool begins_word = true;
  for (const char c : step.substr(0, step.find(':'))) {
    if (c != '-') constant += begins_word ? static_cast<char>(std::toupper(c)) : c;
    begins_word = c == '-';
  }
  return constant + "Version";
}

template <class Number>
void add_bytes(const std::vector<Number>& numbers, DigestBuilder& digest) {
  digest.add(std::as_bytes(std::span(numbers)));
}

// Scans lie outside their drive and are made while they are read.
Result<void> add_scans(const Drive& drive, DigestBuilder& digest) {
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const Result<Scan> scan = drive.store->read(i);
    if (!scan) return scan.error();
    std::vector<double> coordinates_m;
    for (const Eigen::Vector3d& point_m : scan->points_m) {
      coordinates_m.insert(coordinates_m.end(), {point_m.x(), point_m.y(), point_m.z()});
    }
    add_bytes(coordinates_m, digest);
    add_bytes(scan->time_offset_ns, digest);
  }
  return {};
}

// Measured by a clock, so they differ from run to run.
bool is_time(const std::string& column) {
  return column.find("time_ms") != std::string::npos ||
         column.find("time_ratio") != std::string::npos;
}

// Returns whether there were any.
bool remove_times(Table& table) {
  const std::size_t before = table.columns.size();
  for (std::size_t column = table.columns.size(); column-- > 0;) {
    if (!is_time(table.columns[column])) continue;
    const auto offset = static_cast<std::ptrdiff_t>(column);
    table.columns.erase(table.columns.begin() + offset);
    for (std::vector<Cell>& row : table.rows) row.erase(row.begin() + offset);
  }
  return table.columns.size() < before;
}

// Everything in an artifact; its one dump leaves some of these out.
std::vector<Table> all_tables(const ArtifactSet::Entry& entry) {
  const void* artifact = entry.value.get();
  if (entry.type == &artifact_type<Evaluation>()) {
    return tables(*static_cast<const Evaluation*>(artifact));
  }
  if (entry.type == &artifact_type<DriveTracks>()) {
    return tables(*static_cast<const DriveTracks*>(artifact));
  }
  return {entry.type->print(artifact)};
}

// Of the encoded bytes. Of the dump in full precision, without times and with all points of a
// drive, where an artifact is not encoded or holds times.
Result<Digest> digest_of(const ArtifactSet::Entry& entry) {
  std::vector<Table> all = all_tables(entry);
  bool has_times = false;
  for (Table& table : all) has_times = remove_times(table) || has_times;
  if (entry.type->write && !has_times) return sha256(entry.type->write(entry.value.get()));
  DigestBuilder digest;
  for (const Table& table : all) digest.add(format_table(table, TableFormat::kCsv));
  if (entry.type == &artifact_type<Drive>()) {
    const Result<void> added = add_scans(*static_cast<const Drive*>(entry.value.get()), digest);
    if (!added) return added.error();
  }
  return digest.finish();
}

Result<StepOutput> output_of(const PassStep& step, const ArtifactSet& artifacts) {
  const ArtifactSet::Entry& entry = artifacts.entry(step.output);
  StepOutput output;
  output.step = step.name;
  output.version_constant = version_constant(step.name);
  output.version = step.version;
  output.artifact = step.output;
  output.encoding = std::string(entry.type->name) + " " + std::to_string(entry.type->version);
  output.inputs = step.inputs;
  output.table = entry.type->print(entry.value.get());
  remove_times(output.table);
  const Result<Digest> digest = digest_of(entry);
  if (!digest) return digest.error();
  output.digest = *digest;
  return output;
}

// What steps take and no step makes: its keys are digests of its content.
StepOutput outside_inputs(const std::vector<PassStep>& steps, const ArtifactSet& artifacts) {
  std::set<std::string> names;
  for (const PassStep& step : steps) names.insert(step.inputs.begin(), step.inputs.end());
  for (const PassStep& step : steps) names.erase(step.output);
  StepOutput inputs;
  inputs.step = inputs.artifact = "inputs";
  inputs.table.columns = {"artifact", "digest"};
  for (const std::string& name : names) {
    inputs.table.rows.push_back({name, to_hex(artifacts.entry(name).key)});
  }
  inputs.digest = sha256(format_table(inputs.table, TableFormat::kCsv));
  return inputs;
}

Result<RunOutput> run(const std::string& name, const std::vector<PassStep>& steps,
                      const RunOptions& options, ArtifactSet& artifacts) {
  RunOutput output{name, {outside_inputs(steps, artifacts)}};
  std::vector<StepReport> reports;
  const Result<void> ran = run_pipeline(steps, options, {}, artifacts, reports);
  if (!ran) return ran.error();
  for (const PassStep& step : steps) {
    Result<StepOutput> made = output_of(step, artifacts);
    if (!made) return made.error();
    made->inputs.emplace_back("inputs");
    output.steps.push_back(std::move(*made));
  }
  return output;
}

StepOutput map_file(const CompiledMap& map) {
  const std::vector<std::byte> bytes = encode_map(map);
  StepOutput output;
  output.step = output.artifact = "map-file";
  output.inputs = {"inputs", "compiled-map"};
  output.digest = sha256(bytes);
  output.table.facts = {{"bytes", static_cast<std::int64_t>(bytes.size())}};
  return output;
}

Result<RunOutput> run_evaluation(const std::string& name, CompileConfig config,
                                 const CompiledMap& map, const RunOptions& options) {
  aim_at_map(map, config);
  ArtifactSet artifacts;
  const Result<void> provided = provide_evaluation(config, artifacts);
  if (!provided) return provided.error();
  provide_map(map, artifacts);
  return run(name, evaluate_pipeline(config), options, artifacts);
}

}  // namespace

Result<std::vector<RunOutput>> run_town(const std::string& name,
                                        const std::filesystem::path& config_file, int threads) {
  const Result<CompileConfig> config = load_compile_config(config_file, {});
  if (!config) return config.error();
  ArtifactSet artifacts;
  const Result<void> provided = provide_drives(*config, artifacts);
  if (!provided) return provided.error();
  RunOptions options;
  options.threads = threads;
  options.seed = static_cast<std::uint64_t>(config->annotation.seed);
  Result<RunOutput> compiled = run(name, compile_pipeline(*config), options, artifacts);
  if (!compiled) return compiled.error();
  const auto& map = artifacts.get<CompiledMap>("compiled-map");
  compiled->steps.push_back(map_file(map));
  std::vector<RunOutput> runs = {std::move(*compiled)};
  if (config->evaluation.scans.empty()) return runs;
  Result<RunOutput> evaluated = run_evaluation(name + "-evaluate", *config, map, options);
  if (!evaluated) return evaluated.error();
  runs.push_back(std::move(*evaluated));
  return runs;
}

}  // namespace sightline::golden
