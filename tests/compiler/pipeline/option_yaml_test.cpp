#include "compiler/pipeline/option_yaml.h"
#include "tests/support/value_of.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(YamlTree, KeepsWhatIsWrittenAndItsLine) {
  const YamlNode root = value_of(parse_yaml("a: 1\nb:\n  - 'two'\n  - {c: }\n"));
  EXPECT_EQ(root.find("a")->scalar, "1");
  const YamlNode* list = root.find("b");
  ASSERT_EQ(list->values.size(), 2U);
  EXPECT_EQ(list->values[0].scalar, "two");
  EXPECT_EQ(list->values[0].place(), "line 3, column 5");
  EXPECT_EQ(list->values[1].find("c")->kind, YamlNode::Kind::kNull);
  EXPECT_EQ(root.find("c"), nullptr);
  EXPECT_EQ(parse_yaml("")->kind, YamlNode::Kind::kNull);
}

// Ten lines that stand for ten thousand million.
TEST(YamlTree, RefusesTextsThatRepeatThemselvesBeyondAllUse) {
  std::string text = "l0: &l0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string name = "l" + std::to_string(i);
    const std::string before = ", *l" + std::to_string(i - 1);
    text += name + ": &" + name + " [x";
    for (int k = 0; k < 10; ++k) text += before;
    text += "]\n";
  }
  EXPECT_EQ(code_of(parse_yaml(text)), ErrorCode::kMalformedText);
  EXPECT_EQ(parse_yaml(std::string(100, '[') + std::string(100, ']')).error().code,
            ErrorCode::kMalformedText);
}

struct Twice {
  const char* text;
  const char* place;
  const char* hint;
};

// 100 KB that stand for 2 GB.
TEST(YamlTree, RefusesALongScalarThatIsRepeatedBeyondAllUse) {
  std::string text = "a: &a " + std::string(40'000, 'x') + "\nb: [";
  for (int i = 0; i < 20'000; ++i) text += "*a,";
  EXPECT_EQ(code_of(parse_yaml(text + "]\n")), ErrorCode::kMalformedText);
}

// yaml-cpp takes each for documents without end, none of which consumes a byte.
TEST(YamlTree, RefusesTextsThatYamlCppReadsWithoutEnd) {
  for (const char* text : {",95)r`ae:", ",", "a: 1\n---\n,"}) {
    EXPECT_EQ(code_of(parse_yaml(text)), ErrorCode::kMalformedText) << text;
  }
}

TEST(YamlTree, RefusesASecondKeyOrDocumentWithItsLine) {
  const std::vector<Twice> cases = {
      {"a: 1\nb: 2\na: 3\n", "line 3, column 1", "a second 'a'; the first one is in line 1"},
      {"a:\n  b: 1\n  'b': 2\n", "line 3, column 3", "the first one is in line 2"},
      {"{a: 1, a: 2}", "line 1, column 8", "a second 'a'"},
      {"- {a: 1}\n- {a: 1, a: 2}\n", "line 2, column 10", "a second 'a'"},
      {"a: 1\n---\nb: 2\n", "line 3", "a second document"},
      {"a: 1\n...\nb: 2\n", "line 3", "a second document"},
      {"---\n---\na: 1\n", "line 3", "a second document"}};
  for (const Twice& twice : cases) {
    const Error refused = failure_of(parse_yaml(twice.text), twice.text);
    EXPECT_EQ(refused.code, ErrorCode::kMalformedText);
    EXPECT_EQ(refused.place.rfind(twice.place, 0), 0U) << twice.text << refused.place;
    EXPECT_NE(refused.message.find(twice.hint), std::string::npos) << refused.message;
  }
  for (const char* text :
       {"%YAML 1.2\n---\na: 1\n...\n", "a: 1\n---\n", "a: {c: 1}\nb: {c: 1}\n"}) {
    EXPECT_NE(value_of(parse_yaml(text)).find("a"), nullptr) << text;
  }
}

TEST(YamlTree, NamesTheQuoteThatIsNotClosed) {
  const std::vector<Twice> cases = {
      {"a: 1\nb: \"two\nc: 3\n", "line 2, column 4", "this quote is not closed"},
      {"a: {b: 'c}\n", "line 1, column 8", "this quote is not closed"},
      {"# it's\na: \"b\n", "line 2, column 4", "this quote is not closed"}};
  for (const Twice& open : cases) {
    const Error refused = failure_of(parse_yaml(open.text), open.text);
    EXPECT_EQ(refused.place, open.place) << open.text << refused.message;
    EXPECT_NE(refused.message.find(open.hint), std::string::npos) << refused.message;
  }
}

TEST(OptionYaml, SetsFieldsAndLeavesOtherKeysToItsCaller) {
  double cell_m = 1.0;
  std::vector<OptionField> fields = {number("cell_m", cell_m, "edge, m", 0.1, 10.0)};
  ASSERT_TRUE(set_fields(*parse_yaml("{cell_m: 2.5, rules: [1]}"), "here", fields, {"rules"}));
  EXPECT_EQ(cell_m, 2.5);
  ASSERT_TRUE(set_fields(*parse_yaml(""), "here", fields));
  EXPECT_EQ(cell_m, 2.5);
  const Result<void> unknown = set_fields(*parse_yaml("\ncel_m: 1"), "here", fields, {"rules"});
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::kUnknownKey);
  EXPECT_EQ(unknown.error().message, "unknown key 'cel_m' in here; did you mean 'cell_m'?");
  EXPECT_EQ(unknown.error().place, "line 2, column 1");
  EXPECT_EQ(set_fields(*parse_yaml("cell_m: 20"), "here", fields).error().place,
            "line 1, column 9");
  EXPECT_EQ(cell_m, 2.5);
}

}  // namespace
}  // namespace sightline
