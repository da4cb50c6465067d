// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/label_preset_menu.h"

#include <QActionGroup>
#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QStandardPaths>

#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/workbench/naming.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

LabelPresetMenu::LabelPresetMenu(Workbench& workbench, QWidget* parent)
    : QMenu(tr("Label &preset"), parent), workbench_(workbench) {
  setObjectName("label_presets");
  setToolTipsVisible(true);
  connect(this, &QMenu::aboutToShow, this, &LabelPresetMenu::fill);
  const auto enable = [this] { set_enabled(menuAction(), workbench_.has_volume(), tr("Open a volume first")); };
  enable();
  connect(&workbench_, &Workbench::volume_changed, this, enable);
  fill();
}

QString LabelPresetMenu::folder() {
  return QStandardPaths::writableLocation(QStandardPaths::GenericConfigLocation) + "/simplexseg/labels";
}

void LabelPresetMenu::fill() {
  clear();
  const QString current = text(workbench_.scene().labels.preset);
  auto* group = new QActionGroup(this);
  bool listed = current.isEmpty();
  const auto add = [&](QString title, const QString& name, const QString& tip) {
    QAction* entry = addAction(title.replace('&', "&&"));
    entry->setCheckable(true);
    entry->setChecked(name == current);
    entry->setToolTip(tip);
    group->addAction(entry);
    listed = listed || name == current;
    connect(entry, &QAction::triggered, this, [this, name] { choose_label_preset(workbench_, name); });
  };
  add(tr("None"), "", tr("New segmentations are named 'mesh 1', 'mesh 2' and so on"));
  addSeparator();
  for (const LabelPreset& preset : label_presets()) {
    QStringList names;
    for (const PresetLabel& label : preset.labels)
      if (names.size() < 6) names << text(label.name);
    add(text(preset.title), text(preset.name), names.join(", ") + QString(QChar(0x2026)));
  }
  const QStringList files = QDir(folder()).entryList({"*.json"}, QDir::Files, QDir::Name);
  if (!files.isEmpty()) addSeparator();
  for (const QString& file : files) {
    const QString path = QDir(folder()).filePath(file);
    add(QFileInfo(file).completeBaseName(), path, QDir::toNativeSeparators(path));
  }
  if (!listed) add(QFileInfo(current).completeBaseName(), current, QDir::toNativeSeparators(current));
  addSeparator();
  QAction* load = addAction(tr("&Load from a file..."), this, &LabelPresetMenu::choose_file);
  load->setToolTip(tr("Load your own names, colours, labels and codes; files in %1 are listed here").arg(folder()));
}

void LabelPresetMenu::choose_file() {
  const QString path = local_path(
      QFileDialog::getOpenFileUrl(this, tr("Load a label preset"), url_of(folder()), tr("Presets (*.json)")));
  if (!path.isEmpty()) choose_label_preset(workbench_, path);
}

}  // namespace simplexseg
