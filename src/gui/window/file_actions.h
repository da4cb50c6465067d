// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QString>
#include <QStringList>
#include <filesystem>

#include "io/dicom_series.h"
#include "io/load_input.h"
#include "io/recovery.h"

class QMimeData;
class QWidget;

namespace simplexseg {

class ActionTable;
class BackgroundJob;
class Workbench;

/// Open and save, each with its dialog; long work goes to the background.
class FileActions : public QObject {
  Q_OBJECT
 public:
  FileActions(Workbench& workbench, BackgroundJob& job, ActionTable& actions, QWidget& window);

  /// Loads in the background and opens; asks about unsaved changes first. Of a folder or a DICOMDIR with several
  /// series, or with one that is 4D or damaged, the user chooses.
  void open(const QString& path) { open_all({path}); }
  /// The same for what was dropped: of several files a series.
  void open_all(const QStringList& paths);
  /// Opens what was loaded; `path`: where from. Throws Error.
  void take(LoadedInput input, const std::filesystem::path& path);
  /// Opens work that was kept as if it had never been closed: unsaved, under the name that it had. Throws Error.
  void take_up(LoadedInput input, const WorkNote& note);
  /// False when the user wants to stay.
  bool may_discard();
  QString scene_name() const;
  /// What was opened or saved as a scene last; empty before.
  const QString& path() const { return last_path_; }
  /// Where the scene was saved, or opened from; empty: nowhere.
  const QString& scene_path() const { return scene_path_; }
  /// Where files are offered to be saved or opened.
  QString usual_folder() const;
  /// What is open is a DICOM image: files of DICOM can refer to it.
  bool is_dicom() const { return is_dicom_; }

  // Each says what it did or what went wrong; false when it failed or was called off.
  bool save_scene();
  bool save_scene_as();
  bool save_scene_to(const QString& path);
  void save_labels_to(const QString& path);
  void save_meshes_to(const QString& folder, const QString& extension = ".ply");

  /// Where the next file is offered to be saved: beside the last one, named after volume and scene, `what` and the
  /// ending; a name that no file has.
  QString offered_path(const QString& what, const QString& ending) const;

  /// The files and folders of a drop; empty when there is none.
  static QStringList dropped_paths(const QMimeData* data);

 signals:
  void name_changed();
  void about_to_take();  ///< what is open goes, unless the next cannot be opened

 private:
  void enable_actions();
  void say_warnings(const std::vector<std::string>& warnings);
  /// Looks for series in the background, and loads the one that the user chooses.
  void find_series(const QStringList& paths);
  void choose_series(FoundSeries found);
  /// `volume`: of a 4D file; 0: the user chooses where there are several. `series`: of a DICOM folder; empty: the
  /// largest.
  void load(const QString& path, int volume, const std::string& series);
  void choose_volume(const QString& path, int count);
  void choose_and_open();
  void choose_and_open_folder();
  void choose_and_save_labels();
  void choose_and_save_meshes();

  Workbench& workbench_;
  BackgroundJob& job_;
  ActionTable& actions_;
  QWidget& window_;
  QString scene_path_;  ///< empty until saved or opened
  QString last_path_;
  bool is_dicom_ = false;
};

}  // namespace simplexseg
