// SPDX-License-Identifier: Apache-2.0
#include "gui/window/key_file.h"

#include <QJsonDocument>
#include <QJsonObject>
#include <vector>

#include "io/platform/atomic_file.h"
#include "io/scene/json_input.h"
#include "io/scene/parameter_text.h"

namespace simplexseg {
namespace {

constexpr int kVersion = 1;
constexpr const char *kHead = "simplexseg_keys", *kKeys = "keys", *kKind = "key";

/// Names of all acts with a key.
std::vector<std::string> names_with_key() {
  std::vector<std::string> names;
  for (const Binding& binding : bindings())
    if (*binding.keys) names.emplace_back(name_of(binding.act));
  return names;
}

QKeySequence read_key(const JsonInput& input) {
  const QString written = QString::fromStdString(input.text_or_empty());
  if (written.isEmpty()) return {};
  const QKeySequence key(written, QKeySequence::PortableText);
  const QString defect = key.isEmpty() ? QObject::tr("it is unknown") : defect_of_key(key);
  if (!defect.isEmpty())
    input.fail("the key '" + written.toStdString() + "' cannot be used: " + defect.toStdString(),
               "name another key, such as Ctrl+K");
  return key;
}

KeyAssignment keys_of(const JsonInput& input) {
  if (!input.has(kHead))
    input.fail(std::string("it contains no keys: '") + kHead + "' is missing", "choose a file that Export has written");
  input.expect_keys({kHead, kKeys});
  input[kHead].integer_between(kVersion, kVersion);
  const JsonInput list = input[kKeys];
  std::map<Act, QKeySequence> changed;
  for (const std::string& name : list.keys()) {
    const std::optional<Act> act = act_named(name);
    if (!act) list[name].fail("the action " + unknown_name(name, names_with_key()), "correct it");
    changed[*act] = read_key(list[name]);
  }
  KeyAssignment keys = KeyAssignment::with_changed(changed);
  for (const Binding& binding : bindings()) {
    if (!*binding.keys) continue;
    const QKeySequence key = keys.key_of(binding.act);
    if (const std::optional<Act> other = keys.act_with(key, binding.act))
      list.fail(std::string(name_of(binding.act)) + " and " + name_of(*other) + " have the same key, " +
                    key.toString(QKeySequence::PortableText).toStdString(),
                "give one of them another key, or none");
  }
  return keys;
}

}  // namespace

std::string keys_json(const KeyAssignment& keys) {
  QJsonObject list;
  for (const auto& [act, key] : keys.changed()) list[name_of(act)] = key.toString(QKeySequence::PortableText);
  return QJsonDocument(QJsonObject{{kHead, kVersion}, {kKeys, list}}).toJson().toStdString();
}

KeyAssignment keys_of_json(const std::string& text, const std::string& place) {
  return keys_of(JsonInput::of_text(text, place, kKind));
}

KeyAssignment read_key_file(const std::filesystem::path& path) { return keys_of(JsonInput::open(path, kKind)); }

void write_key_file(const std::filesystem::path& path, const KeyAssignment& keys) {
  AtomicFile file(path);
  write_bytes(file, keys_json(keys));
  file.commit();
}

}  // namespace simplexseg
