#pragma once

#include <cstdint>
#include <string_view>

#include "formats/base/result.h"
#include "passes/pass/options.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// What a pass says of itself, once, beside its function:
//
//   Result<TiledNds> build_ndt(PassContext& ctx, const BuildNdtOptions& options,
//                              const SurfacePoints& points);
//   inline constexpr Pass kBuildNdt{"build-ndt", 1, "nds", "The NDT map", &build_ndt};
//
// Its inputs, its options and its output are read off the signature. The section of the
// configuration, the published schema, the cache key, `--stop-after` and `dump --what` follow.
template <class Output, class Options, class... Inputs>
struct Pass {
  std::string_view name;   // "build-ndt": of the step, and of the section with its options
  std::uint32_t version;   // raised in the commit after which equal inputs give other bytes
  std::string_view table;  // what `dump --what` calls the output: "nds"
  std::string_view help;   // one line above the section of the configuration
  Result<Output> (*run)(PassContext&, const Options&, const Inputs&...);
};

template <class Output, class Options, class... Inputs>
Pass(std::string_view, std::uint32_t, std::string_view, std::string_view,
     Result<Output> (*)(PassContext&, const Options&, const Inputs&...))
    -> Pass<Output, Options, Inputs...>;

// The same pass on other inputs: name, version, table and help are those of `pass`.
template <class Output, class Options, class... Inputs, class... OtherInputs>
constexpr Pass<Output, Options, OtherInputs...> variant_of(
    const Pass<Output, Options, Inputs...>& pass,
    Result<Output> (*run)(PassContext&, const Options&, const OtherInputs&...)) {
  return {pass.name, pass.version, pass.table, pass.help, run};
}

// The options of a pass that has none.
struct NoOptions {};
inline std::vector<OptionField> option_fields(NoOptions&) { return {}; }

}  // namespace sightline
