#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "compiler/views/verdict/verdict.h"
#include "formats/text/json_text.h"

// The verdict in the forms in which people and programs read it. All have the same words.

namespace sightline {

// "Verdict: partly", without its end: what is coloured at a terminal.
std::string verdict_head(const MapJudgement& judgement);
// ". No answer is good enough ... On drive ...": the rest of the paragraph, without its end.
std::string verdict_rest(const MapJudgement& judgement);

// For people: verdict, promise and next command in lines of at most 120 columns.
std::string to_text(const MapJudgement& judgement);
// "**Verdict: 🟡 partly.** ...": a paragraph.
std::string to_markdown(const MapJudgement& judgement);

// As "verdict" in schemas/verdict.schema.json.
nlohmann::ordered_json to_json(const MapJudgement& judgement);

// Breaks paragraphs at spaces so that no line is longer, as far as words allow. Further lines of a
// paragraph begin with `indent` spaces. Widths count bytes.
std::string wrapped(const std::string& text, std::size_t width = 120, std::size_t indent = 2);

}  // namespace sightline
