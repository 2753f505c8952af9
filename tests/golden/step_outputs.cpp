#include "tests/golden/step_outputs.h"

#include <algorithm>
#include <cctype>
#include <map>

#include "compiler/driver/configuration.h"
#include "compiler/driver/evaluate_plan.h"
#include "compiler/driver/pipelines.h"
#include "compiler/driver/provide_inputs.h"
#include "compiler/pipeline/runner.h"
#include "formats/annotation/measured_drives.h"
#include "formats/map/map_reader.h"

namespace sightline::golden {
namespace {

// "ingest:localization" -> "kIngest", which holds the version.
std::string version_constant(const std::string& step) {
  std::string constant = "k";
  bool begins_word = true;
  for (const char c : step.substr(0, step.find(':'))) {
    if (c != '-') constant += begins_word ? static_cast<char>(std::toupper(c)) : c;
    begins_word = c == '-';
  }
  return constant;
}

template <class Number>
void add_bytes(const std::vector<Number>& numbers, DigestBuilder& digest) {
  digest.add(std::as_bytes(std::span(numbers)));
}

// Scans lie outside their drive and are made while they are read.
Result<void> add_scans(const Drive& drive, DigestBuilder& digest) {
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    SIGHTLINE_ASSIGN(const Scan scan, drive.store->read(i));
    std::vector<double> coordinates_m;
    for (const Eigen::Vector3d& point_m : scan.points_m) {
      coordinates_m.insert(coordinates_m.end(), {point_m.x(), point_m.y(), point_m.z()});
    }
    add_bytes(coordinates_m, digest);
    add_bytes(scan.time_offset_ns, digest);
  }
  return {};
}

// Measured by a clock, so they differ from run to run.
bool is_time(const std::string& column) {
  return column.find("time_ms") != std::string::npos ||
         column.find("time_ratio") != std::string::npos;
}

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
Result<std::vector<Table>> all_tables(const ArtifactSet::Entry& entry) {
  const void* artifact = entry.value.get();
  if (entry.type == &artifact_type<Evaluation>()) {
    return tables(*static_cast<const Evaluation*>(artifact));
  }
  if (entry.type == &artifact_type<DriveTracks>()) {
    return tables(*static_cast<const DriveTracks*>(artifact));
  }
  SIGHTLINE_ASSIGN(const Table table, entry.type->print(artifact));
  return std::vector<Table>{table};
}

// Of the encoded bytes. Of the dump in full precision, without times and with all points of a
// drive, where an artifact is not encoded or holds times.
Result<Digest> digest_of(const ArtifactSet::Entry& entry) {
  SIGHTLINE_ASSIGN(std::vector<Table> all, all_tables(entry));
  bool has_times = entry.type == &artifact_type<MeasuredDrives>();  // in no column of its dump
  for (Table& table : all) has_times = remove_times(table) || has_times;
  if (entry.type->write && !has_times) {
    Sha256Stream encoded;
    SIGHTLINE_TRY(entry.type->write(entry.value.get(), [&](std::span<const std::byte> piece) {
      encoded.add(piece);
      return Result<void>();
    }));
    return encoded.finish();
  }
  DigestBuilder digest;
  for (const Table& table : all) digest.add(format_table(table, TableFormat::kCsv));
  if (entry.type == &artifact_type<Drive>()) {
    SIGHTLINE_TRY(add_scans(*static_cast<const Drive*>(entry.value.get()), digest));
  }
  return digest.finish();
}

Result<StepOutput> output_of(const Plan& plan, const PassStep& step, const ArtifactSet& artifacts) {
  const ArtifactSet::Entry& entry = artifacts.entry({step.output});
  StepOutput output;
  output.step = step.name;
  output.version_constant = version_constant(step.name);
  output.version = step.version;
  output.artifact = plan.artifact({step.output}).name;
  output.encoding = std::string(entry.type->name) + " " + std::to_string(entry.type->version);
  for (const std::size_t input : step.inputs) {
    output.inputs.push_back(plan.artifact({input}).name);
  }
  SIGHTLINE_ASSIGN(output.table, entry.type->print(entry.value.get()));
  remove_times(output.table);
  SIGHTLINE_ASSIGN(output.digest, digest_of(entry));
  return output;
}

// What steps take and neither they nor earlier runs make: its keys are digests of its content.
StepOutput outside_inputs(const Plan& plan, const ArtifactSet& artifacts,
                          const std::vector<RunOutput>& earlier) {
  std::map<std::string, AnyWire> outside;
  for (const PassStep& step : plan.steps()) {
    for (const std::size_t input : step.inputs) outside[plan.artifact({input}).name] = {input};
  }
  for (const AnyWire made : plan.made()) outside.erase(plan.artifact(made).name);
  for (const RunOutput& run : earlier) {
    for (const StepOutput& output : run.steps) outside.erase(output.artifact);
  }
  StepOutput inputs;
  inputs.step = inputs.artifact = "inputs";
  inputs.table.columns = {"artifact", "digest"};
  for (const auto& [name, wire] : outside) {
    inputs.table.rows.push_back({name, to_hex(artifacts.entry(wire).key)});
  }
  inputs.digest = sha256(format_table(inputs.table, TableFormat::kCsv));
  return inputs;
}

bool is_in(const std::vector<RunOutput>& runs, const StepOutput& wanted) {
  const auto is_same = [&](const StepOutput& output) {
    return output.step == wanted.step && output.version == wanted.version &&
           output.digest == wanted.digest;
  };
  return std::ranges::any_of(
      runs, [&](const RunOutput& run) { return std::ranges::any_of(run.steps, is_same); });
}

Result<void> add_run(const std::string& name, const Plan& plan, const RunOptions& options,
                     ArtifactSet& artifacts, std::vector<RunOutput>& runs) {
  RunOutput output{name, {outside_inputs(plan, artifacts, runs)}};
  std::vector<StepReport> reports;
  SIGHTLINE_TRY(run_plan(plan, {}, options, {}, artifacts, reports));
  for (const PassStep& step : plan.steps()) {
    SIGHTLINE_ASSIGN(StepOutput made, output_of(plan, step, artifacts));
    made.inputs.emplace_back("inputs");
    if (!is_in(runs, made)) output.steps.push_back(std::move(made));
  }
  runs.push_back(std::move(output));
  return {};
}

// The dump of a compiled map leaves out most of what it was made of; its file holds all of it.
StepOutput map_file(std::span<const std::byte> bytes, const StepOutput& emit) {
  StepOutput output;
  output.step = output.artifact = "map-file";
  output.inputs = emit.inputs;
  output.inputs.push_back(emit.artifact);
  output.digest = sha256(bytes);
  output.table.facts = {{"bytes", static_cast<std::int64_t>(bytes.size())}};
  return output;
}

struct Compiled {
  CompiledMap map;
  ByFamily<ErrorModel> model;
};

Result<Compiled> add_compile(const std::string& name, const CompileConfig& config,
                             const ByFamily<ErrorModel>* model, const RunOptions& options,
                             std::vector<RunOutput>& runs) {
  const CompilePlan compile =
      compile_plan(config, model != nullptr ? ModelSource::kGiven : ModelSource::kTrained);
  ArtifactSet artifacts;
  SIGHTLINE_TRY(provide_drives(compile, {}, artifacts));
  if (model != nullptr) artifacts.provide(compile.given_model, *model);
  SIGHTLINE_TRY(add_run(name, compile.plan, options, artifacts, runs));
  const StoredBytes& stored = artifacts.get(compile.map).bytes;
  SIGHTLINE_ASSIGN(const std::vector<std::byte> file, stored.read(0, stored.size()));
  SIGHTLINE_ASSIGN(CompiledMap map, read_map(file));
  map.ndt = artifacts.get(compile.ndt);  // not rounded
  Compiled compiled{std::move(map), artifacts.get(compile.model)};
  SIGHTLINE_ASSIGN(const StepOutput emit,
                   output_of(compile.plan, compile.plan.steps().back(), artifacts));
  runs.back().steps.push_back(map_file(file, emit));
  return compiled;
}

Result<void> add_evaluation(const std::string& name, const CompileConfig& config,
                            const CompiledMap& map, const RunOptions& options,
                            std::vector<RunOutput>& runs) {
  if (config.evaluation.scans.empty()) return {};
  const EvaluatePlan evaluate = evaluate_plan(config, map);
  ArtifactSet artifacts;
  SIGHTLINE_TRY(provide_drive(evaluate, {}, artifacts));
  provide_map(map, evaluate, artifacts);
  return add_run(name, evaluate.plan, options, artifacts, runs);
}

}  // namespace

Result<std::vector<RunOutput>> run_town(const std::string& name,
                                        const std::filesystem::path& config_file, int threads) {
  SIGHTLINE_ASSIGN(const CompileConfig config, load_compile_config(config_file, {}));
  RunOptions options;
  options.threads = threads;
  options.seed = static_cast<std::uint64_t>(config.annotation.seed);
  std::vector<RunOutput> runs;
  SIGHTLINE_ASSIGN(const Compiled compiled, add_compile(name, config, nullptr, options, runs));
  SIGHTLINE_TRY(add_evaluation(name + "-evaluate", config, compiled.map, options, runs));
  SIGHTLINE_TRY(add_compile(name + "-given-model", config, &compiled.model, options, runs));
  return runs;
}

}  // namespace sightline::golden
