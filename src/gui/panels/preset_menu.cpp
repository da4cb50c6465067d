// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/preset_menu.h"

#include <QDir>
#include <QFileDialog>
#include <QStandardPaths>
#include <filesystem>

#include "core/error.h"
#include "gui/input/key_map.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/workbench/workbench.h"
#include "io/scene/preset_io.h"

namespace simplexseg {
namespace {
constexpr const char* kEnding = ".preset.json";
}  // namespace

PresetMenu::PresetMenu(Workbench& workbench, std::function<ItemId()> target, QWidget* parent)
    : QMenu(parent), workbench_(workbench), target_(std::move(target)) {
  setObjectName("presets");
  setToolTipsVisible(true);
  connect(this, &QMenu::aboutToShow, this, &PresetMenu::fill);
  fill();
}

QString PresetMenu::folder() {
  return QStandardPaths::writableLocation(QStandardPaths::GenericConfigLocation) + "/simplexseg/presets";
}

void PresetMenu::fill() {
  clear();
  const QString no_mesh =
      tr("There is no segmentation yet: add one in the panel Segmentations, or with the tool Seed (%1)")
          .arg(key_hint(Act::ToolSeed));
  const auto add = [&](const QString& text, const QString& tip, auto&& act) {
    QAction* entry = addAction(text, this, act);
    entry->setToolTip(tip);
    set_enabled(entry, workbench_.active_mesh(), no_mesh);
  };
  add(tr("&Default settings"), tr("Reset all forces and the simulation to their defaults"), [this] {
    workbench_.apply(SetParameters{target_(), default_force_parameters(), default_simulation_parameters()});
  });
  const QStringList files = QDir(folder()).entryList({QString("*") + kEnding}, QDir::Files, QDir::Name);
  if (!files.isEmpty()) addSeparator();
  for (const QString& file : files) {
    const QString path = QDir(folder()).filePath(file);
    QString name = file.chopped(static_cast<int>(qstrlen(kEnding)));
    add(name.replace('&', "&&"), QDir::toNativeSeparators(path), [this, path] { load_from(path); });
  }
  addSeparator();
  add(tr("&Save as preset..."), tr("Save the settings of the active segmentation and of the simulation to a file"),
      [this] { choose_and_save(); });
  add(tr("&Load from a file..."), tr("Load settings from any preset file"), [this] { choose_and_load(); });
}

bool PresetMenu::save_to(const QString& path) {
  const MeshItem* mesh = workbench_.active_mesh();
  if (!mesh) return false;
  try {
    write_preset(to_path(path), {mesh->parameters, workbench_.scene().simulation});
  } catch (const std::exception& error) {
    workbench_.notify(Severity::Failure, QString::fromUtf8(error.what()));
    return false;
  }
  workbench_.notify(Severity::Note, tr("Saved the settings to %1").arg(path));
  return true;
}

bool PresetMenu::load_from(const QString& path) {
  try {
    const Preset preset = read_preset(to_path(path));
    return workbench_.apply(SetParameters{target_(), preset.forces, preset.simulation});
  } catch (const std::exception& error) {
    workbench_.notify(Severity::Failure, QString::fromUtf8(error.what()));
    return false;
  }
}

void PresetMenu::choose_and_save() {
  QDir().mkpath(folder());
  QString path = local_path(QFileDialog::getSaveFileUrl(
      this, tr("Save the settings"), url_of(folder() + "/my settings" + kEnding), tr("Presets (*.preset.json)")));
  if (path.isEmpty()) return;
  if (!path.endsWith(".json")) path += kEnding;
  save_to(path);
}

void PresetMenu::choose_and_load() {
  const QString path =
      local_path(QFileDialog::getOpenFileUrl(this, tr("Load settings"), url_of(folder()), tr("Presets (*.json)")));
  if (!path.isEmpty()) load_from(path);
}

}  // namespace simplexseg
