// SPDX-License-Identifier: Apache-2.0
#include "gui/window/key_settings.h"

#include <exception>

#include "gui/input/key_map.h"
#include "gui/window/key_file.h"

namespace simplexseg {
namespace {
constexpr const char* kChangedKeys = "changed_keys";
}

KeySettings::KeySettings() : settings_(QSettings::IniFormat, QSettings::UserScope, "simplexseg", "keys") {
  KeyMap& map = KeyMap::shared();
  const QString stored = settings_.value(kChangedKeys).toString();
  try {
    if (!stored.isEmpty()) map.assign(keys_of_json(stored.toStdString(), settings_.fileName().toStdString()));
  } catch (const std::exception& error) {
    fault_ = QString::fromUtf8(error.what());
  }
  connect(&map, &KeyMap::changed, this, [this, &map] {
    if (map.keys().is_default())
      settings_.remove(kChangedKeys);
    else
      settings_.setValue(kChangedKeys, QString::fromStdString(keys_json(map.keys())));
  });
}

}  // namespace simplexseg
