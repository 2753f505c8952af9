#include "formats/foreign/lanes/osm_text.h"

#include <algorithm>
#include <optional>

#include "formats/text/quoted_text.h"

// A library of XML writes a document anew, with its own quotes and blanks. Where elements begin and
// end is all that is asked for here; whether the document is one, a library has been asked before.

namespace sightline {
namespace {

constexpr std::size_t kNone = std::string_view::npos;

struct Span {
  std::size_t begin = 0;
  std::size_t end = 0;
};

struct TagPlace {
  Span span;
  std::string_view key;  // as they are written
  std::string_view value;
};

// A child of <osm>.
struct Child {
  std::string_view name;
  Span span;
  std::size_t content_end = 0;  // where its end tag begins; the span's end where it has none
  std::vector<TagPlace> tags;
};

Error malformed(const std::string& what) { return {ErrorCode::kMalformedText, what}; }

// Finds the children of the first <osm> of a document.
class ChildFinder {
 public:
  explicit ChildFinder(std::string_view text) : text_(text) {}

  Result<std::vector<Child>> find() {
    while (true) {
      at_ = text_.find('<', at_);
      if (at_ == kNone) break;
      if (!step()) return malformed("an element of the XML does not end");
    }
    if (!has_osm_ || depth_ != 0) return malformed("found no whole element osm");
    return std::move(children_);
  }

 private:
  bool skip_past(std::string_view end, std::size_t from) {
    const std::size_t found = text_.find(end, from);
    if (found == kNone) return false;
    at_ = found + end.size();
    return true;
  }

  // Over one piece of markup.
  bool step() {
    const std::string_view rest = text_.substr(at_);
    if (rest.starts_with("<!--")) return skip_past("-->", at_ + 4);
    if (rest.starts_with("<![CDATA[")) return skip_past("]]>", at_ + 9);
    if (rest.starts_with("<!")) return skip_past(">", at_);
    if (rest.starts_with("<?")) return skip_past("?>", at_ + 2);
    return rest.starts_with("</") ? end_tag() : start_tag();
  }

  bool end_tag() {
    const std::size_t begin = at_;
    if (depth_ == 0 || !skip_past(">", at_)) return false;
    --depth_;
    if (is_in_osm_ && depth_ == 1) {
      children_.back().content_end = begin;
      children_.back().span.end = at_;
    }
    if (depth_ == 0) is_in_osm_ = false;
    return true;
  }

  bool start_tag() {
    const std::size_t begin = at_;
    std::size_t end = at_ + 1;
    for (char quote = 0; end < text_.size() && (quote != 0 || text_[end] != '>'); ++end) {
      const char c = text_[end];
      if (quote == 0 && (c == '"' || c == '\'')) {
        quote = c;
      } else if (c == quote) {
        quote = 0;
      }
    }
    if (end >= text_.size()) return false;
    at_ = end + 1;
    const bool is_empty = text_[end - 1] == '/';
    const std::string_view inside = text_.substr(begin + 1, end - begin - 1);
    const std::string_view name = inside.substr(0, inside.find_first_of(" \t\r\n/"));
    if (depth_ == 0 && !has_osm_ && name == "osm") has_osm_ = is_in_osm_ = true;
    if (is_in_osm_ && depth_ == 1) children_.push_back({name, {begin, at_}, at_, {}});
    if (is_in_osm_ && depth_ == 2 && name == "tag" && is_empty) {
      children_.back().tags.push_back(
          {{begin, at_}, attribute(inside, "k"), attribute(inside, "v")});
    }
    if (!is_empty) ++depth_;
    if (depth_ == 0) is_in_osm_ = false;
    return true;
  }

  static std::string_view attribute(std::string_view inside, std::string_view name) {
    for (std::size_t at = inside.find(name); at != kNone; at = inside.find(name, at + 1)) {
      const std::size_t equals = inside.find_first_not_of(" \t\r\n", at + name.size());
      const bool is_name = at > 0 && std::string_view(" \t\r\n").find(inside[at - 1]) != kNone &&
                           equals != kNone && inside[equals] == '=';
      if (!is_name) continue;
      const std::size_t quote = inside.find_first_of("\"'", equals);
      if (quote == kNone) return {};
      const std::size_t end = inside.find(inside[quote], quote + 1);
      return end == kNone ? std::string_view() : inside.substr(quote + 1, end - quote - 1);
    }
    return {};
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t depth_ = 0;
  bool has_osm_ = false;
  bool is_in_osm_ = false;
  std::vector<Child> children_;
};

// The blanks between the begin of its line and a place; nothing where something else stands there.
std::optional<std::string_view> indent_of(std::string_view text, std::size_t at) {
  const std::size_t line = at == 0 ? 0 : text.rfind('\n', at - 1) + 1;  // npos + 1 is 0
  const std::string_view before = text.substr(line, at - line);
  if (before.find_first_not_of(" \t") != kNone) return std::nullopt;
  return before;
}

// With the rest of its line where that is blank.
Span whole_lines(std::string_view text, Span span) {
  const std::optional<std::string_view> indent = indent_of(text, span.begin);
  const std::size_t next = text.find_first_not_of(" \t\r", span.end);
  if (!indent || next == kNone || text[next] != '\n') return span;
  return {span.begin - indent->size(), next + 1};
}

// Writes lines in the manner of a document.
struct Manner {
  std::string indent;  // of a child of <osm>
  std::string line_end;

  explicit Manner(std::string_view text, const std::vector<Child>& children)
      : indent("  "), line_end(text.find("\r\n") == kNone ? "\n" : "\r\n") {
    if (children.empty()) return;
    if (const auto found = indent_of(text, children.front().span.begin)) indent = *found;
  }
  [[nodiscard]] std::string line(int depth, const std::string& content) const {
    std::string blanks = indent;
    for (int i = 1; i < depth; ++i) blanks += indent.empty() ? "  " : indent;
    return concat(blanks, "<", content, ">", line_end);
  }
  [[nodiscard]] std::string tags(const OsmTags& tags) const {
    std::string lines;
    for (const auto& [key, value] : tags) {
      lines += line(2, concat("tag k=\"", xml_text(key), "\" v=\"", xml_text(value), "\"/"));
    }
    return lines;
  }
  [[nodiscard]] std::string element(const OsmElement& element) const {
    OsmTags all = element.tags;
    all.emplace_back(kAddedBy);
    std::string lines = line(1, element.head);
    for (const std::string& ref : element.refs) {
      lines += line(2, concat("nd ref=\"", xml_text(ref), "\"/"));
    }
    return lines + tags(all) + line(1, "/" + element.head.substr(0, element.head.find(' ')));
  }
};

struct Insertion {
  std::size_t at = 0;
  std::string lines;
};

// Before a place: at the begin of its line where nothing else stands there, else on lines between.
// A carriage return that stands alone there stays alone: with a line feed behind it, it would be a
// line end of another manner.
Insertion before(std::string_view text, std::size_t at, std::string lines, const Manner& manner) {
  const std::optional<std::string_view> indent = indent_of(text, at);
  if (indent) return {at - indent->size(), std::move(lines)};
  const std::string apart = at > 0 && text[at - 1] == '\r' ? " " : "";
  return {at, apart + manner.line_end + std::move(lines)};
}

// The first child of one of these names; the last child where none has one.
std::size_t place_of(const std::vector<Child>& children,
                     const std::vector<std::string_view>& names) {
  for (const Child& child : children) {
    if (std::ranges::find(names, child.name) != names.end()) return child.span.begin;
  }
  return children.empty() ? 0 : children.back().span.begin;
}

}  // namespace

Result<std::string> without_additions(std::string_view text,
                                      const std::vector<std::string_view>& key_prefixes) {
  SIGHTLINE_ASSIGN(const std::vector<Child> children, ChildFinder(text).find());
  std::vector<Span> removed;
  for (const Child& child : children) {
    const bool is_added =
        child.name != "relation" && std::ranges::any_of(child.tags, [](const TagPlace& tag) {
          return tag.key == kAddedBy.first && tag.value == kAddedBy.second;
        });
    if (is_added) removed.push_back(whole_lines(text, child.span));
    if (child.name != "relation") continue;
    for (const TagPlace& tag : child.tags) {
      const bool is_ours = std::ranges::any_of(
          key_prefixes, [&](std::string_view prefix) { return tag.key.starts_with(prefix); });
      if (is_ours) removed.push_back(whole_lines(text, tag.span));
    }
  }
  std::string kept;
  std::size_t at = 0;
  for (const Span& span : removed) {
    kept += text.substr(at, span.begin - at);
    at = span.end;
  }
  return kept + std::string(text.substr(at));
}

Result<std::string> with_additions(std::string_view text, const OsmAdditions& additions) {
  SIGHTLINE_ASSIGN(const std::vector<Child> children, ChildFinder(text).find());
  const Manner manner(text, children);
  std::vector<Insertion> insertions;
  std::string nodes, ways;
  for (const OsmElement& node : additions.nodes) nodes += manner.element(node);
  for (const OsmElement& way : additions.ways) ways += manner.element(way);
  if (!nodes.empty()) {
    insertions.push_back(
        before(text, place_of(children, {"way", "relation"}), std::move(nodes), manner));
  }
  if (!ways.empty()) {
    insertions.push_back(before(text, place_of(children, {"relation"}), std::move(ways), manner));
  }
  std::size_t relation = 0;
  for (const Child& child : children) {
    if (child.name != "relation") continue;
    const std::size_t number = relation++;
    if (number >= additions.of_relations.size() || additions.of_relations[number].empty()) continue;
    if (child.content_end == child.span.end) return malformed("a lanelet without content");
    insertions.push_back(
        before(text, child.content_end, manner.tags(additions.of_relations[number]), manner));
  }
  if (relation != additions.of_relations.size()) {
    return malformed(
        concat("found ", relation, " relations, expected ", additions.of_relations.size()));
  }
  std::ranges::stable_sort(insertions, {}, &Insertion::at);
  std::string made;
  std::size_t at = 0;
  for (const Insertion& insertion : insertions) {
    made += text.substr(at, insertion.at - at);
    made += insertion.lines;
    at = insertion.at;
  }
  return made + std::string(text.substr(at));
}

}  // namespace sightline
