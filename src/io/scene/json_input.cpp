// SPDX-License-Identifier: Apache-2.0
#include "io/scene/json_input.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/files.h"
#include "io/scene/parameter_text.h"

namespace simplexseg {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

const json& json_of(const void* node) { return *static_cast<const json*>(node); }

/// Position of a byte of the text, for example "line 3, column 14". `byte`: number of the byte, from 1.
std::string place_of(const std::string& text, std::size_t byte) {
  const std::size_t end = std::min(byte > 0 ? byte - 1 : 0, text.size());
  const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n') + 1;
  const std::size_t start = end == 0 ? std::string::npos : text.rfind('\n', end - 1);
  const std::size_t column = start == std::string::npos ? end + 1 : end - start;
  return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

/// Cause in a message of the JSON library, without the library's prefix and position.
std::string reason_of(const std::string& message) {
  const std::size_t at = message.find(": ");
  return one_line(at == std::string::npos ? message : message.substr(at + 2));
}

/// Parser callback that finds the first key that occurs twice in an object.
class DuplicateFinder {
 public:
  bool operator()(int depth, json::parse_event_t event, json& value) {
    if (event == json::parse_event_t::object_start)
      open_.resize(static_cast<std::size_t>(depth) + 1), open_.back().clear();
    if (event == json::parse_event_t::key) {
      open_.resize(static_cast<std::size_t>(depth));
      const std::string& key = value.get_ref<const std::string&>();
      if (!open_.back().insert(key).second && first_.empty()) first_ = key;
    }
    return true;
  }
  const std::string& first() const { return first_; }

 private:
  std::vector<std::set<std::string>> open_;
  std::string first_;
};

}  // namespace

struct JsonInput::Document {
  std::string file;
  json root;
};

JsonInput::JsonInput(std::shared_ptr<const Document> document, const void* node, std::string where)
    : document_(std::move(document)), node_(node), where_(std::move(where)) {}

JsonInput JsonInput::open(const fs::path& path, const std::string& kind) {
  const std::string bytes = read_bytes(path);
  if (std::all_of(bytes.begin(), bytes.end(), is_space)) {
    throw Error("cannot read " + quoted(path), "the file is empty", "choose a " + kind + " file");
  }
  return of_text(bytes, quoted(path), kind);
}

JsonInput JsonInput::of_text(const std::string& text, const std::string& place, const std::string& kind) {
  auto document = std::make_shared<Document>();
  document->file = place;
  DuplicateFinder duplicates;
  try {
    document->root = json::parse(text, std::ref(duplicates));
  } catch (const json::parse_error& error) {
    throw Error(place + ", " + place_of(text, error.byte),
                "it is not a valid " + kind + " file: " + reason_of(error.what()), "correct the file");
  } catch (const json::exception& error) {
    throw Error(place, "it is not a valid " + kind + " file: " + reason_of(error.what()), "use finite numbers");
  }
  if (!duplicates.first().empty()) {
    throw Error(place, "the key '" + duplicates.first() + "' occurs twice in one object", "delete one of the two");
  }
  const void* root = &document->root;
  return JsonInput(std::move(document), root, "");
}

JsonInput JsonInput::member(const void* node, const std::string& place) const {
  return JsonInput(document_, node, where_.empty() && place[0] == '.' ? place.substr(1) : where_ + place);
}

void JsonInput::fail(const std::string& why, const std::string& what_to_do) const {
  throw Error(document_->file + (where_.empty() ? "" : ": " + where_), why, what_to_do);
}

void JsonInput::fail_for_type(const std::string& what_to_do) const {
  fail(std::string("the value has the type ") + json_of(node_).type_name(), what_to_do);
}

void JsonInput::expect_object() const {
  if (!json_of(node_).is_object()) fail_for_type("write an object {...}");
}

void JsonInput::expect_array() const {
  if (!json_of(node_).is_array()) fail_for_type("write a list [...]");
}

void JsonInput::expect_keys(const std::vector<std::string>& known) const {
  for (const std::string& key : keys()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    fail("the key " + unknown_name(key, known), "correct or delete it");
  }
}

bool JsonInput::has(const std::string& key) const {
  expect_object();
  return json_of(node_).contains(key);
}

JsonInput JsonInput::operator[](const std::string& key) const {
  if (!has(key)) fail("the key '" + key + "' is missing", "add it");
  return member(&json_of(node_).at(key), "." + key);
}

std::vector<std::string> JsonInput::keys() const {
  expect_object();
  std::vector<std::string> names;
  for (const auto& entry : json_of(node_).items()) names.push_back(entry.key());
  return names;
}

int JsonInput::size() const {
  expect_array();
  return static_cast<int>(json_of(node_).size());
}

JsonInput JsonInput::operator[](int index) const {
  if (index < 0 || index >= size())
    fail("it has " + counted(json_of(node_).size(), "value"), "add element " + std::to_string(index + 1));
  return member(&json_of(node_)[static_cast<std::size_t>(index)],
                std::string("[").append(std::to_string(index)).append("]"));
}

double JsonInput::number() const {
  if (!json_of(node_).is_number()) fail_for_type("write a finite number");
  const double value = json_of(node_).get<double>();
  if (!std::isfinite(value)) fail("the number is not finite", "write a finite number");
  return value;
}

double JsonInput::number_between(double minimum, double maximum) const {
  const double value = number();
  if (!(value >= minimum && value <= maximum)) {
    fail(json(value).dump() + " is out of range",
         "use a value from " + json(minimum).dump() + " to " + json(maximum).dump());
  }
  return value;
}

int JsonInput::integer_between(int minimum, int maximum) const {
  const double value = number();
  if (value != std::floor(value) || value < minimum || value > maximum) {
    fail("the value is " + json_of(node_).dump(),
         "use a whole number from " + std::to_string(minimum) + " to " + std::to_string(maximum));
  }
  return static_cast<int>(value);
}

bool JsonInput::boolean() const {
  if (!json_of(node_).is_boolean()) fail_for_type("write true or false");
  return json_of(node_).get<bool>();
}

bool JsonInput::is_text() const { return json_of(node_).is_string(); }

std::string JsonInput::text_or_empty() const {
  if (!json_of(node_).is_string()) fail_for_type("write a text in quotes");
  std::string value = json_of(node_).get<std::string>();
  if (value.find('\0') != std::string::npos) fail("the text contains a zero byte", "delete it");
  return value;
}

std::string JsonInput::text() const {
  std::string value = text_or_empty();
  if (value.empty()) fail("the text is empty", "write something or delete the key");
  return value;
}

Eigen::Vector3d JsonInput::vector3() const {
  if (size() != 3) fail("it has " + counted(size(), "value"), "write three numbers: [x, y, z]");
  const auto element = [this](int e) { return (*this)[e].number_between(-kMaxMillimetres, kMaxMillimetres); };
  return {element(0), element(1), element(2)};
}

float JsonInput::parameter(const ParameterInfo& info) const {
  const std::string place = document_->file + ": " + where_;
  return info.kind == ParameterKind::Choice ? choice_from_text(place, info, text())
                                            : checked_parameter(place, info, number());
}

}  // namespace simplexseg
