#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "formats/artifact.h"
#include "formats/base/hash.h"
#include "passes/pass/pass.h"

// How a pass, which is a plain function, becomes a step of a plan. Types are read off its
// signature; what they mean to the runner is here.

namespace sightline {

// An artifact that can be written down.
template <class X>
concept Encodable = requires(const X& artifact, ByteWriter& writer, ByteReader& reader, X& out) {
  encode(artifact, writer);
  decode(reader, out);
};

// The artifact that X is, or that X is a form of, as ArtifactTraits<X>::Artifact says: another
// struct for the same bytes, which a pass may ask for in its place. A map's NDs whole, or tile by
// tile.
template <class X>
struct FormOf {
  using Artifact = X;
};
template <class X>
requires requires { typename ArtifactTraits<X>::Artifact; }
struct FormOf<X> {
  using Artifact = typename ArtifactTraits<X>::Artifact;
};
template <class X>
using ArtifactOf = typename FormOf<X>::Artifact;

// What the runner can do with any artifact of one type, in one form.
struct ArtifactType {
  std::string_view name;
  std::uint32_t version = 0;
  std::function<Result<void>(const void*)> check;
  std::function<Result<Table>(const void*)> print;  // error: cannot-read
  // Empty where the artifact is neither Encodable nor InPieces.
  std::function<Result<void>(const void*, const ByteSink&)> write;
  std::function<Result<std::shared_ptr<const void>>(const StoredBytes&)> read;
  // Part of it lies outside: the scans of a drive. Only a step that gives it back may be loaded.
  bool refers_outside = false;
  bool is_form = false;  // another than the whole artifact: much of it may lie in a file
};

template <class X>
const ArtifactType& artifact_type() {
  static const ArtifactType kType = [] {
    ArtifactType type;
    type.name = ArtifactTraits<X>::kName;
    type.version = ArtifactTraits<X>::kVersion;
    type.check = [](const void* x) { return validate(*static_cast<const X*>(x)); };
    type.print = [](const void* x) -> Result<Table> { return dump(*static_cast<const X*>(x)); };
    type.refers_outside = requires { ArtifactTraits<X>::kRefersOutside; };
    type.is_form = !std::is_same_v<ArtifactOf<X>, X>;
    if constexpr (InPieces<X>) {
      type.write = [](const void* x, const ByteSink& sink) {
        return visit_bytes(*static_cast<const X*>(x), sink);
      };
      type.read = [](const StoredBytes& stored) -> Result<std::shared_ptr<const void>> {
        SIGHTLINE_ASSIGN(X artifact, from_stored<X>(stored));
        return std::shared_ptr<const void>(std::make_shared<const X>(std::move(artifact)));
      };
    } else if constexpr (Encodable<X>) {
      type.write = [](const void* x, const ByteSink& sink) {
        return sink(to_bytes(*static_cast<const X*>(x)));
      };
      type.read = [](const StoredBytes& stored) -> Result<std::shared_ptr<const void>> {
        SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, stored.read(0, stored.size()));
        SIGHTLINE_ASSIGN(X artifact, from_bytes<X>(bytes));
        return std::shared_ptr<const void>(std::make_shared<const X>(std::move(artifact)));
      };
    }
    return type;
  }();
  return kType;
}

// What a parameter of a pass means: how many artifacts it takes, and of which type.
template <class Parameter>
struct ParameterOf;
template <class X>
struct ParameterOf<const X&> {
  using Form = X;
  static const X& from(const std::vector<const X*>& artifacts) { return *artifacts.front(); }
};
template <class X>
struct ParameterOf<const X*> {
  using Form = X;
  static const X* from(const std::vector<const X*>& artifacts) {
    return artifacts.empty() ? nullptr : artifacts.front();
  }
};
template <class X>
struct ParameterOf<Many<X>> {
  using Form = X;
  static Many<X> from(const std::vector<const X*>& artifacts) { return artifacts; }
};
template <class Parameter>
using FormTaken = typename ParameterOf<Parameter>::Form;

// One step of a plan: a pass with its options, and which of the plan's artifacts it takes and
// makes.
struct PassStep {
  using Inputs = std::vector<std::shared_ptr<const void>>;

  std::string name;  // unique in the plan: "build-ndt", "ingest:localization"
  std::uint32_t version = 1;
  Stage stage = Stage::kDrives;
  Cost cost;
  std::vector<std::pair<std::string, std::string>> options;  // as texts, in the order of the fields
  std::vector<std::size_t> inputs;                           // indices of artifacts of the plan
  std::vector<std::size_t> input_counts;  // [parameter of the pass]: of these, in their order
  std::size_t output = 0;
  std::vector<const ArtifactType*> input_types;  // [input]: in the form that the pass takes
  const ArtifactType* output_type = nullptr;     // in the form that it makes
  std::function<Result<std::shared_ptr<const void>>(PassContext&, const Inputs&)> run;
  // Restores what lies outside an output that was loaded from the cache, from the inputs: a step
  // has it where its output has reattach(Output&, Parameters...). Else empty.
  std::function<std::shared_ptr<const void>(std::shared_ptr<const void> loaded, const Inputs&)>
      reattach;
};

// The name of its pass: that of the step without a label.
inline std::string_view pass_of(const PassStep& step) {
  return std::string_view(step.name).substr(0, step.name.find(':'));
}

namespace pipeline_detail {

template <class Options>
std::vector<std::pair<std::string, std::string>> option_texts(Options options) {
  std::vector<std::pair<std::string, std::string>> texts;
  for (const OptionField& field : option_fields(options)) {
    texts.emplace_back(field.name, to_text(field));
  }
  return texts;
}

// Inputs of a step, as the parameters of its pass.
template <class... Parameters>
class Arguments {
 public:
  Arguments(const PassStep::Inputs& inputs, const std::vector<std::size_t>& counts) {
    fill(inputs, counts, std::index_sequence_for<Parameters...>{});
  }

  // What `call` returns for them.
  template <class Call>
  decltype(auto) apply(Call&& call) const {
    return std::apply(
        [&](const auto&... artifacts) -> decltype(auto) {
          return call(ParameterOf<Parameters>::from(artifacts)...);
        },
        artifacts_);
  }

 private:
  template <std::size_t... I>
  void fill(const PassStep::Inputs& inputs, const std::vector<std::size_t>& counts,
            std::index_sequence<I...>) {
    auto next = inputs.begin();
    const auto take = [&]<class X>(std::vector<const X*>& artifacts, std::size_t count) {
      for (; count > 0; --count) artifacts.push_back(static_cast<const X*>((next++)->get()));
    };
    (take(std::get<I>(artifacts_), counts[I]), ...);
  }

  std::tuple<std::vector<const FormTaken<Parameters>*>...> artifacts_;
};

}  // namespace pipeline_detail

// A step that runs `pass`; the plan names it and connects it. `counts`: how many artifacts each
// parameter of the pass takes.
template <class Output, class Options, class... Parameters>
PassStep make_step(const Pass<Output, Options, Parameters...>& pass, const Options& options,
                   const std::vector<std::size_t>& counts) {
  using Arguments = pipeline_detail::Arguments<Parameters...>;
  PassStep step;
  step.version = pass.version;
  step.stage = pass.stage;
  step.cost = pass.cost;
  step.options = pipeline_detail::option_texts(options);
  step.input_counts = counts;
  const std::vector<const ArtifactType*> types = {&artifact_type<FormTaken<Parameters>>()...};
  for (std::size_t i = 0; i < counts.size(); ++i) {
    step.input_types.insert(step.input_types.end(), counts[i], types[i]);
  }
  step.output_type = &artifact_type<Output>();
  step.run = [run = pass.run, options, counts](
                 PassContext& ctx,
                 const PassStep::Inputs& inputs) -> Result<std::shared_ptr<const void>> {
    SIGHTLINE_ASSIGN(Output output,
                     Arguments(inputs, counts).apply([&](Parameters... taken) -> Result<Output> {
                       return run(ctx, options, taken...);
                     }));
    return std::shared_ptr<const void>(std::make_shared<const Output>(std::move(output)));
  };
  if constexpr (requires(Output & made, Parameters... taken) { reattach(made, taken...); }) {
    step.reattach = [counts](std::shared_ptr<const void> loaded,
                             const PassStep::Inputs& inputs) -> std::shared_ptr<const void> {
      Output output = *static_cast<const Output*>(loaded.get());
      Arguments(inputs, counts).apply([&](Parameters... taken) { reattach(output, taken...); });
      return std::make_shared<const Output>(std::move(output));
    };
  }
  return step;
}

}  // namespace sightline
