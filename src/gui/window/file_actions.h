// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QString>
#include <QStringList>
#include <filesystem>

#include "io/dicom/dicom_series.h"
#include "io/scene/load_input.h"
#include "io/scene/recovery.h"

class QMimeData;
class QWidget;

namespace simplexseg {

class ActionTable;
class BackgroundJob;
class Workbench;

/// Opens and saves files, each with its dialog; long operations run in the background.
class FileActions : public QObject {
  Q_OBJECT
 public:
  FileActions(Workbench& workbench, BackgroundJob& job, ActionTable& actions, QWidget& window);

  /// Loads `path` in the background and opens it; asks about unsaved changes first. Does nothing while the job is busy.
  /// The user chooses in a dialog if a folder or DICOMDIR has several series, or one that is 4D or damaged, and if a
  /// file is 4D.
  void open(const QString& path) { open_all({path}); }
  /// Opens dropped files or folders like open(); several files are searched for DICOM series.
  void open_all(const QStringList& paths);
  /// Opens loaded input; `path` is its source. Throws Error when it cannot be opened.
  void open_loaded(LoadedInput input, const std::filesystem::path& path);
  /// Opens recovered work under its original name, marked as unsaved. Throws Error when it cannot be opened.
  void restore(LoadedInput input, const AutosaveInfo& info);
  /// Asks whether to save unsaved changes. Returns false if the user cancels or saving fails.
  bool may_discard();
  QString scene_name() const;
  /// Path that was last opened, or saved as a scene; empty before that.
  const QString& path() const { return last_path_; }
  /// Path of the scene file; empty if there is none.
  const QString& scene_path() const { return scene_path_; }
  /// Initial folder of file dialogs.
  QString usual_folder() const;
  /// Returns true if the open image is DICOM, so that DICOM files can refer to it.
  bool is_dicom() const { return is_dicom_; }

  // Each of these functions shows a message about success or failure. The functions for scenes return false if saving
  // failed or was cancelled; labels and meshes are saved in the background.
  bool save_scene();
  bool save_scene_as();
  bool save_scene_to(const QString& path);
  void save_labels_to(const QString& path);
  /// Saves the measurements of the scene in the background, in the format of the file name (save_measurements(), or
  /// write_case_report() without the name of the patient).
  void save_measurements_to(const QString& path);
  void save_meshes_to(const QString& folder, const QString& extension = ".ply");
  /// Saves all surfaces in the background to one file, .3mf or .glb.
  void save_surfaces_to(const QString& path);

  /// Suggested path for a new file: in the last folder, named after volume and scene, followed by `what`, a number if
  /// the file exists already, and `ending`.
  QString suggested_path(const QString& what, const QString& ending) const;

  /// Local files and folders of a drop; may be empty.
  static QStringList dropped_paths(const QMimeData* data);

 signals:
  void name_changed();
  void about_to_open();  ///< the open scene is about to be replaced

 private:
  void enable_actions();
  void show_warnings(const std::vector<std::string>& warnings);
  /// Searches for DICOM series in the background, and loads the one that the user chooses.
  void find_series(const QStringList& paths);
  void choose_series(FoundSeries found);
  /// `volume`: number in a 4D file; 0: the user chooses if there are several. `series`: UID in a DICOM folder; empty:
  /// the largest series.
  void load(const QString& path, int volume, const std::string& series);
  void choose_volume(const QString& path, int count);
  void choose_and_open();
  void choose_and_open_folder();
  void choose_and_save_labels();
  void choose_and_save_meshes();
  void choose_and_save_measurements();

  Workbench& workbench_;
  BackgroundJob& job_;
  ActionTable& actions_;
  QWidget& window_;
  QString scene_path_;  ///< empty until saved or opened
  QString last_path_;
  bool is_dicom_ = false;
};

}  // namespace simplexseg
