// SPDX-License-Identifier: Apache-2.0
#include "gui/window/window_memory.h"

#include <QFileInfo>
#include <QMenu>
#include <algorithm>

#include "gui/look/qt_text.h"
#include "gui/views/view_grid.h"
#include "gui/window/file_actions.h"
#include "gui/window/main_window.h"
#include "gui/window/side_panels.h"
#include "gui/window/start_page.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {
constexpr std::size_t kMostFiles = 12;
constexpr const char *kGeometry = "geometry", *kFiles = "files";
constexpr const char *kResearcher = "researcher", *kLargeView = "large_view";  // -1: four equal views
constexpr const char *kNeighbours = "neighbours", *kStep = "neighbour_step";   // orientation of the slices, -1: none
constexpr const char *kClipOn = "clip_on", *kClipFlipped = "clip_flipped";     // one bit for each CutPlane
constexpr const char *kImageOnCaps = "image_on_caps", *kVolumeMode = "volume_3d";

int bits_of(const std::array<bool, kCutPlanes>& flags) {
  int bits = 0;
  for (std::size_t n = 0; n < flags.size(); ++n) bits |= flags[n] ? 1 << n : 0;
  return bits;
}

std::array<bool, kCutPlanes> flags_of(int bits) {
  std::array<bool, kCutPlanes> flags{};
  for (std::size_t n = 0; n < flags.size(); ++n) flags[n] = (bits >> n & 1) != 0;
  return flags;
}
}  // namespace

WindowMemory::WindowMemory(MainWindow& window)
    : window_(window), settings_(QSettings::IniFormat, QSettings::UserScope, "simplexseg", "window") {
  read();
  show_recent();
  window_.panels().set_researcher(settings_.value(kResearcher, false).toBool());
  if (const int large = settings_.value(kLargeView, -1).toInt(); large >= 0 && large < 4)
    window_.views().set_layout(ViewLayout::OneAndThree, large);
  window_.views().set_neighbour_step(std::clamp(settings_.value(kStep, 1).toInt(), 1, 1000));
  if (const int plane = settings_.value(kNeighbours, -1).toInt(); plane >= 0 && plane < 3)
    window_.views().set_layout(ViewLayout::Neighbours, plane);
  read_space();
  connect(&window_.files(), &FileActions::name_changed, this, &WindowMemory::file_opened);
  connect(&window_.files(), &FileActions::about_to_open, this, [this] {
    store_contrast();
    is_opened_ = false;
  });
}

WindowMemory::~WindowMemory() {
  settings_.setValue(kGeometry, window_.saveGeometry());
  settings_.setValue(kResearcher, window_.panels().researcher());
  const ViewGrid& views = window_.views();
  const auto main_of = [&](ViewLayout layout) { return views.view_layout() == layout ? views.main_view() : -1; };
  settings_.setValue(kLargeView, main_of(ViewLayout::OneAndThree));
  settings_.setValue(kNeighbours, main_of(ViewLayout::Neighbours));
  settings_.setValue(kStep, views.neighbour_step());
  const ViewState& view = window_.workbench().view;
  settings_.setValue(kClipOn, bits_of(view.clip.on));
  settings_.setValue(kClipFlipped, bits_of(view.clip.flipped));
  settings_.setValue(kImageOnCaps, view.clip.image_on_caps);
  settings_.setValue(kVolumeMode, static_cast<int>(view.volume_mode));
  store_contrast();
  write();
}

void WindowMemory::read_space() {
  ViewState& view = window_.workbench().view;
  view.clip.on = flags_of(settings_.value(kClipOn, 0).toInt());
  view.clip.flipped = flags_of(settings_.value(kClipFlipped, 0).toInt());
  view.clip.image_on_caps = settings_.value(kImageOnCaps, true).toBool();
  if (const int mode = settings_.value(kVolumeMode, 0).toInt(); mode >= 0 && mode <= 2)
    view.volume_mode = static_cast<VolumeMode>(mode);
  window_.workbench().view_edited();
}

bool WindowMemory::restore_geometry() { return window_.restoreGeometry(settings_.value(kGeometry).toByteArray()); }

QStringList WindowMemory::recent() const {
  QStringList paths;
  for (const File& file : files_) paths << file.path;
  return paths;
}

void WindowMemory::read() {
  const int count = settings_.beginReadArray(kFiles);
  for (int n = 0; n < count; ++n) {
    settings_.setArrayIndex(n);
    const QString path = text(std::filesystem::path(settings_.value("path").toByteArray().toStdString()));
    if (!path.isEmpty())
      files_.push_back({path, settings_.value("window").toDouble(), settings_.value("level").toDouble()});
  }
  settings_.endArray();
}

void WindowMemory::write() {
  settings_.beginWriteArray(kFiles, static_cast<int>(files_.size()));
  for (std::size_t n = 0; n < files_.size(); ++n) {
    settings_.setArrayIndex(static_cast<int>(n));
    settings_.setValue("path", QByteArray::fromStdString(to_path(files_[n].path).native()));
    settings_.setValue("window", files_[n].window);
    settings_.setValue("level", files_[n].level);
  }
  settings_.endArray();
}

void WindowMemory::file_opened() {
  const QString path = QFileInfo(window_.files().path()).absoluteFilePath();
  if (path == open_ && is_opened_) return;  // the open file was saved
  open_ = path;
  is_opened_ = true;
  File file{path};
  const auto known = std::find_if(files_.begin(), files_.end(), [&](const File& f) { return f.path == path; });
  if (known != files_.end()) {
    file = *known;
    files_.erase(known);
  }
  files_.insert(files_.begin(), file);
  if (files_.size() > kMostFiles) files_.resize(kMostFiles);
  const bool has_saved_view = window_.workbench().scene().view.has_value();  // stored in the scene file
  if (file.window > 0 && window_.workbench().has_volume() && !has_saved_view) {
    window_.workbench().view.window = file.window;
    window_.workbench().view.level = file.level;
    window_.workbench().view_edited();
  }
  write();
  show_recent();
}

void WindowMemory::store_contrast() {
  if (open_.isEmpty() || files_.empty() || !window_.workbench().has_volume()) return;
  files_.front().window = window_.workbench().view.window;
  files_.front().level = window_.workbench().view.level;
}

void WindowMemory::show_recent() {
  window_.start_page().show_recent(recent());
  QMenu* menu = window_.recent_menu();
  menu->clear();
  for (const QString& path : recent()) {
    if (!path_exists(path)) continue;
    menu->addAction(QString(path).replace('&', "&&"), &window_.files(), [this, path] { window_.files().open(path); });
  }
  menu->setEnabled(!menu->isEmpty());
}

}  // namespace simplexseg
