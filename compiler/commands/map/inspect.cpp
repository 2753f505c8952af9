#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/result_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/verdict_output.h"
#include "compiler/driver/provide_inputs.h"
#include "compiler/views/text/describe.h"
#include "compiler/views/text/describe_site.h"
#include "compiler/views/text/map_summary_text.h"
#include "compiler/views/text/size_table.h"
#include "compiler/views/verdict/verdict_text.h"
#include "formats/map/map_reader.h"

namespace sightline {
namespace {

struct InspectFlags {
  std::string file;
  std::string evaluation;  // JSON of evaluate; empty: none
  int site = -1;           // below 0: the map as a whole
  bool prints_all = false;
  bool prints_sizes = false;
  ResultFlags result;
};

Result<void> inspect_model(const InspectFlags& flags) {
  if (flags.site >= 0 || !flags.evaluation.empty() || flags.prints_sizes) {
    return Error{ErrorCode::kBadArgument,
                 "--site, --size and --evaluation belong to a map (.slmap); this file is a model",
                 flags.file};
  }
  SIGHTLINE_ASSIGN(const ByFamily<ErrorModel> model, read_model(flags.file));
  if (flags.result.is_json()) return put_result(flags.result, json_text(model_json(model)));
  return put_result(flags.result, describe(model));
}

Result<void> inspect_site(const InspectFlags& flags) {
  if (flags.result.is_json()) {
    return Error{ErrorCode::kBadArgument,
                 "--site has no JSON: use `sightline dump MAP --what predicted --format json`"};
  }
  SIGHTLINE_ASSIGN(const CompiledMap map, read_map(flags.file));
  SIGHTLINE_ASSIGN(const std::string text,
                   describe_site(map, static_cast<std::size_t>(flags.site)));
  return put_result(flags.result, text);
}

Result<void> inspect_sizes(const InspectFlags& flags) {
  if (flags.result.is_json()) {
    return Error{ErrorCode::kBadArgument,
                 "--size has no JSON: `sightline verify MAP --format json` has the sizes"};
  }
  SIGHTLINE_ASSIGN(const CheckedMap checked, read_map_without_nds(flags.file));
  return put_result(flags.result, size_table(checked.summary, route_length_m(checked.map.sites)));
}

// The summary, or all that there is to say, behind the same verdict.
Result<std::string> text_of(const InspectFlags& flags, const InspectedMap& inspected) {
  if (!flags.prints_all) return summary_text(inspected);
  SIGHTLINE_ASSIGN(const CompiledMap map, read_map(flags.file));
  std::string text = to_text(inspected.judgement) + "\n";
  if (inspected.evaluation != nullptr) {
    text += answers_table(*inspected.evaluation, inspected.judgement) + "\n";
  }
  return text + describe(map) + describe(inspected.summary);
}

Result<void> inspect_map(const InspectFlags& flags) {
  if (flags.site >= 0) return inspect_site(flags);
  if (flags.prints_sizes) return inspect_sizes(flags);
  SIGHTLINE_ASSIGN(const CheckedMap checked, read_map_without_nds(flags.file));
  SIGHTLINE_ASSIGN(const std::optional<EvaluationFigures> figures,
                   figures_in(flags.evaluation, checked.map));
  const EvaluationFigures* const evaluation = figures ? &*figures : nullptr;
  const MapJudgement judgement = judge_map(checked.map, evaluation, {.map = flags.file});
  const InspectedMap inspected = {flags.file, checked.map, checked.summary, judgement, evaluation};
  if (flags.result.is_json()) return put_result(flags.result, json_text(to_json(inspected)));
  SIGHTLINE_ASSIGN(const std::string text, text_of(flags, inspected));
  const bool is_for_people = flags.result.output.empty();
  return put_result(flags.result, is_for_people ? with_toned_verdict(judgement, text) : text);
}

Result<void> inspect(const InspectFlags& flags) {
  SIGHTLINE_TRY(try_result(flags.result));
  const bool is_model = std::filesystem::path(flags.file).extension() == ".slmodel";
  return is_model ? inspect_model(flags) : inspect_map(flags);
}

}  // namespace

Verb inspect_verb() {
  const auto flags = std::make_shared<InspectFlags>();
  Verb verb;
  verb.name = "inspect";
  verb.summary = "Show the verdict on a map and its main figures; of a model its card";
  verb.details =
      "The verdict is good, partly, bad or not judged (schemas/gate_rules.md): by the evaluation "
      "file, else by the map's own localization drive. The glossary (schemas/glossary.md) explains "
      "the words: look, returns, evenly spaced, by normals, settle, plan.";
  verb.examples = {"sightline inspect town.slmap",
                   "sightline inspect town.slmap --evaluation evaluation.json",
                   "sightline inspect town.slmap --all        # promises, histograms, model, sizes",
                   "sightline inspect town.slmap --site 40    # why is the range long here?",
                   "sightline inspect town.slmap --size       # what are its bytes?",
                   "sightline inspect city.slmodel            # what was it trained on?"};
  verb.positionals = {
      {.name = "FILE", .help = "The map (.slmap) or model (.slmodel)", .target = &flags->file}};
  verb.flags = {{.names = "--site",
                 .value = "SITE",
                 .help = "Explain the choice at this site, counted from 0, instead",
                 .target = &flags->site,
                 .minimum = 0},
                {.names = "--evaluation",
                 .value = "FILE",
                 .help = "The JSON of `sightline evaluate` for this map, for the verdict",
                 .target = &flags->evaluation},
                {.names = "--size",
                 .help = "Print instead what the bytes of the map are, for each km of route",
                 .target = &flags->prints_sizes},
                {.names = "--all",
                 .help = "Print also promises, histograms, the model card and sizes",
                 .target = &flags->prints_all}};
  add_result_flags(verb, flags->result, {"text", "json"},
                   "json as schemas/inspect.schema.json describes it");
  verb.run = [flags] { return exit_status_of(inspect(*flags)); };
  return verb;
}

}  // namespace sightline
