// SPDX-License-Identifier: Apache-2.0
#include "gui/window/file_actions.h"

#include <QAction>
#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QInputDialog>
#include <QMessageBox>
#include <QMimeData>
#include <QPushButton>
#include <QUrl>
#include <algorithm>
#include <memory>

#include "app/case_report.h"
#include "archive/cache.h"
#include "core/error.h"
#include "gui/input/action_table.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/window/series_dialog.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"
#include "io/platform/data_path.h"
#include "io/platform/file_names.h"
#include "io/platform/output_checks.h"
#include "io/scene/measurement_export.h"
#include "io/scene/scene_export.h"
#include "io/scene/scene_io.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

// Paths may contain any byte of the file system: they are converted by text(), to_path() and local_path() alone.

const char* kVolumeFilter =
    "Volumes and scenes (*.nii *.nii.gz *.hdr *.img *.nrrd *.nhdr *.mha *.mhd *.gipl *.gipl.gz *.mnc *.dcm "
    "*.json);;All files (*)";

/// Returns true if `path` is a series fetched from an archive. Its path in the cache is not shown to users, and no
/// files are saved beside it.
bool is_fetched(const QString& path) {
  return !path.isEmpty() && to_path(path).parent_path().parent_path() == ArchiveCache::archive_cache_folder();
}

QString file_name_of(const QString& series) {
  return QString::fromStdString(distinct_file_names({series.toStdString()}, "series").front());
}

}  // namespace

FileActions::FileActions(Workbench& workbench, BackgroundJob& job, ActionTable& actions, QWidget& window)
    : QObject(&window), workbench_(workbench), job_(job), actions_(actions), window_(window) {
  actions.on(Act::Open, [this] { choose_and_open(); });
  actions.on(Act::OpenFolder, [this] { choose_and_open_folder(); });
  actions.on(Act::SaveScene, [this] { save_scene(); });
  actions.on(Act::SaveSceneAs, [this] { save_scene_as(); });
  actions.on(Act::SaveLabels, [this] { choose_and_save_labels(); });
  actions.on(Act::SaveMeshes, [this] { choose_and_save_meshes(); });
  actions.on(Act::SaveMeasurements, [this] { choose_and_save_measurements(); });
  connect(&workbench_, &Workbench::scene_changed, this, &FileActions::enable_actions);
  connect(&job_, &BackgroundJob::busy_changed, this, &FileActions::enable_actions);
  enable_actions();
}

void FileActions::enable_actions() {
  const QString why_busy = tr("Wait until loading or saving has finished");
  const bool volume = workbench_.has_volume(), meshes = !workbench_.scene().meshes.empty();
  for (const Act act : {Act::Open, Act::OpenFolder}) set_enabled(actions_[act], !job_.busy(), why_busy);
  for (const Act act : {Act::SaveScene, Act::SaveSceneAs})
    set_enabled(actions_[act], volume, tr("There is nothing to save yet"));
  const bool any = meshes || !workbench_.scene().measurements.empty();
  set_enabled(actions_[Act::SaveMeasurements], any && !job_.busy(),
              any ? why_busy : tr("There is no measurement or segmentation to save yet"));
  for (const Act act : {Act::SaveLabels, Act::SaveMeshes}) {
    set_enabled(actions_[act], meshes && !job_.busy(), meshes ? why_busy : tr("There is no segmentation to save yet"));
  }
}

void FileActions::choose_and_save_measurements() {
  QString path = local_path(QFileDialog::getSaveFileUrl(&window_, tr("Save the measurements"),
                                                        url_of(suggested_path("-measurements", ".csv")),
                                                        tr("Table (*.csv);;Report with pictures (*.pdf);;"
                                                           "DICOM structured report and segmentation (*.sr.dcm)")));
  if (!path.isEmpty() && QFileInfo(path).suffix().isEmpty()) path += ".csv";
  if (!path.isEmpty()) save_measurements_to(path);
}

void FileActions::save_measurements_to(const QString& path) {
  const Scene scene = workbench_.session().scene();
  CaseReportInput report{.series = workbench_.series_name().toStdString(),
                         .intensity_unit = workbench_.intensity_unit(),
                         .low_is_bright = workbench_.view.low_is_bright};
  try {
    require_measurement_name(to_path(path), scene);
    for (const std::filesystem::path& file : measurement_files(to_path(path))) require_writable_output(file);
    if (is_case_report(to_path(path)) && !scene.volume_path.empty())
      report.volume_path = find_data(scene.volume_path, {});
  } catch (const std::exception& error) {
    workbench_.notify(Severity::Failure, QString::fromUtf8(error.what()));
    return;
  }
  auto note = std::make_shared<std::string>();
  job_.start(
      tr("Saving %1...").arg(QFileInfo(path).fileName()),
      [=, volume = workbench_.session().volume(), place = to_path(path)] {
        if (is_case_report(place))
          write_case_report(place, scene, volume, report);
        else
          *note = save_measurements(place, scene, volume, report.intensity_unit);
      },
      [=, this] {
        const QString more = note->empty() ? QString() : "; " + QString::fromStdString(*note);
        workbench_.notify(Severity::Note, tr("Saved %1%2").arg(path, more));
      });
}

void FileActions::open_all(const QStringList& paths) {
  if (paths.isEmpty() || paths.front().isEmpty() || job_.busy() || !may_discard()) return;
  const QString& first = paths.front();
  if (paths.size() > 1 || is_folder(first) || is_dicomdir(to_path(first)))
    find_series(paths);
  else
    load(first, 0, {});
}

void FileActions::find_series(const QStringList& paths) {
  std::vector<std::filesystem::path> places;
  places.reserve(static_cast<std::size_t>(paths.size()));
  for (const QString& path : paths) places.push_back(to_path(path));
  auto found = std::make_shared<FoundSeries>();
  const QString what = paths.size() == 1 ? QFileInfo(paths.front()).fileName() : counted_text(paths.size(), "file");
  job_.start(
      tr("Searching %1 for DICOM series...").arg(what), [=] { *found = find_dicom_series(places); },
      [=, this] { choose_series(std::move(*found)); }, BackgroundJob::Cancellable::Yes);
}

void FileActions::choose_series(FoundSeries found) {
  const auto load_one = [this](const DicomSeries& series, int volume) {
    load(text(series.folder), volume, series.is_only_series && !series.damaged ? std::string() : series.uid);
  };
  const DicomSeries& first = found.series.front();
  if (found.series.size() == 1 && found.unreadable.empty() && !first.damaged && first.load_error.empty() &&
      first.volumes == 1) {
    load_one(first, 1);
    return;
  }
  auto* dialog = new SeriesDialog(std::move(found), &window_);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  connect(dialog, &QDialog::accepted, this, [=] { load_one(*dialog->chosen(), dialog->volume()); });
  dialog->open();
}

void FileActions::choose_volume(const QString& path, int count) {
  auto* dialog = new QInputDialog(&window_);
  dialog->setObjectName("volume_dialog");
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowTitle(tr("Open one of several volumes"));
  dialog->setLabelText(
      tr("%1 is 4D and contains %2 volumes. Number of the volume to open:").arg(QFileInfo(path).fileName()).arg(count));
  dialog->setInputMode(QInputDialog::IntInput);
  dialog->setIntRange(1, count);
  connect(dialog, &QInputDialog::intValueSelected, this, [=, this](int volume) { load(path, volume, {}); });
  dialog->open();
}

void FileActions::load(const QString& path, int volume, const std::string& series) {
  if (job_.busy()) return;
  auto input = std::make_shared<LoadedInput>();
  auto volumes = std::make_shared<int>(1);
  const std::filesystem::path file = to_path(path);
  job_.start(
      tr("Loading %1...").arg(QFileInfo(path).fileName()),
      [=] {
        if (volume == 0 && file.extension() != ".json") {
          const VolumeInfo info = read_volume_info(file);
          if (info.frame > 0) *volumes = info.frames;
        }
        if (*volumes == 1) *input = load_input(file, std::max(volume, 1), series);
      },
      [=, this] {
        if (*volumes > 1) {
          choose_volume(path, *volumes);
          return;
        }
        try {
          open_loaded(std::move(*input), file);
        } catch (const std::exception& error) {
          workbench_.notify(Severity::Failure, QString::fromUtf8(error.what()));
        }
      },
      BackgroundJob::Cancellable::Yes);
}

void FileActions::open_loaded(LoadedInput input, const std::filesystem::path& path) {
  emit about_to_open();
  workbench_.open(std::move(input.scene), std::move(input.volume), std::move(input.references),
                  std::move(input.history));
  workbench_.add_volumes(std::move(input.volumes));
  workbench_.add_layer_images(input.layers);
  is_dicom_ = input.is_dicom;
  workbench_.view.low_is_bright = input.low_is_bright;
  const QString series = QString::fromStdString(input.series);
  workbench_.set_title(QString::fromStdString(input.patient),
                       series.isEmpty() ? QFileInfo(text(input.volume_path)).fileName() : series);
  workbench_.set_intensity_unit(input.intensity_unit);
  last_path_ = text(path);
  scene_path_ = path.extension() == ".json" ? text(path) : QString();
  if (!is_utf8(input.volume_path))
    input.warnings.insert(input.warnings.begin(),
                          tr("The path of the image is not UTF-8, so no scene can refer to it and none can be saved. "
                             "Rename the file or its folder, and open it again.")
                              .toStdString());
  show_warnings(input.warnings);
  emit name_changed();
}

void FileActions::restore(LoadedInput input, const AutosaveInfo& info) {
  emit about_to_open();
  workbench_.open(std::move(input.scene), std::move(input.volume), std::move(input.references),
                  std::move(input.history));
  workbench_.add_volumes(std::move(input.volumes));
  workbench_.add_layer_images(input.layers);
  is_dicom_ = input.is_dicom;
  workbench_.view.low_is_bright = input.low_is_bright;
  workbench_.mark_unsaved();
  last_path_ = QString::fromStdString(info.opened);
  scene_path_ = QString::fromStdString(info.scene_file);
  workbench_.notify(Severity::Note, tr("Work restored. Not saved yet."));
  show_warnings(input.warnings);
  emit name_changed();
}

void FileActions::show_warnings(const std::vector<std::string>& warnings) {
  if (warnings.empty()) return;
  QString text = QString::fromUtf8(warnings.front().c_str());
  if (warnings.size() > 1) text += tr(" (and %1 more)").arg(warnings.size() - 1);
  workbench_.notify(Severity::Warning, text);
}

bool FileActions::may_discard() {
  if (!workbench_.has_unsaved_changes()) return true;
  const QString name = scene_name();
  QMessageBox question(
      QMessageBox::Question, tr("Unsaved changes"),
      name.isEmpty() ? tr("Save the changes to the scene first?") : tr("Save the changes to '%1' first?").arg(name),
      QMessageBox::NoButton, &window_);
  question.setInformativeText(tr("If you discard the changes, unsaved segmentations and points are lost."));
  // Custom buttons, because the standard texts of some desktops have no mnemonics.
  QPushButton* save = question.addButton(tr("&Save"), QMessageBox::AcceptRole);
  QPushButton* discard = question.addButton(tr("&Discard"), QMessageBox::DestructiveRole);
  QPushButton* cancel = question.addButton(tr("&Cancel"), QMessageBox::RejectRole);
  question.setDefaultButton(save);
  question.setEscapeButton(cancel);
  question.exec();
  if (question.clickedButton() == save) return save_scene();
  return question.clickedButton() == discard;
}

QString FileActions::scene_name() const {
  if (scene_path_.isEmpty() && is_fetched(last_path_)) return workbench_.series_name();
  return QFileInfo(scene_path_.isEmpty() ? last_path_ : scene_path_).fileName();
}

QString FileActions::suggested_path(const QString& what, const QString& ending) const {
  const auto stem_of = [](const QString& path) { return QFileInfo(path).fileName().section('.', 0, 0); };
  const QString volume_path = text(std::filesystem::path(workbench_.scene().volume_path)), scene = stem_of(scene_path_);
  const QString volume = is_fetched(volume_path) ? file_name_of(workbench_.series_name()) : stem_of(volume_path);
  QStringList parts;
  for (const QString& part : {volume, scene})
    if (!part.isEmpty() && !parts.contains(part)) parts << part;
  const QString base = QDir(usual_folder()).filePath((parts.isEmpty() ? "simplexseg" : parts.join('-')) + what);
  QString path = base + ending;
  for (int number = 2; path_exists(path); ++number) path = base + '-' + QString::number(number) + ending;
  return path;
}

QString FileActions::usual_folder() const {
  if (is_fetched(last_path_)) return QDir::homePath();
  return last_path_.isEmpty() ? QString() : QFileInfo(last_path_).absolutePath();
}

void FileActions::choose_and_open() {
  open(local_path(
      QFileDialog::getOpenFileUrl(&window_, tr("Open a volume or a scene"), url_of(usual_folder()), kVolumeFilter)));
}

void FileActions::choose_and_open_folder() {
  open(local_path(
      QFileDialog::getExistingDirectoryUrl(&window_, tr("Open a folder with a DICOM series"), url_of(usual_folder()))));
}

bool FileActions::save_scene() { return scene_path_.isEmpty() ? save_scene_as() : save_scene_to(scene_path_); }

bool FileActions::save_scene_as() {
  // Desktops distinguish scenes from other JSON files by this extension (packaging/simplexseg.xml).
  const QString ending = ".simplexseg.json";
  QString path = local_path(QFileDialog::getSaveFileUrl(&window_, tr("Save the scene"),
                                                        url_of(suggested_path("", ending)), tr("Scenes (*.json)")));
  if (path.isEmpty()) return false;
  if (!path.endsWith(".json")) path += ending;
  return save_scene_to(path);
}

bool FileActions::save_scene_to(const QString& path) {
  try {
    write_scene(to_path(path), workbench_.scene_to_save(), workbench_.session().history());
  } catch (const std::exception& error) {
    workbench_.notify(Severity::Failure, QString::fromUtf8(error.what()));
    return false;
  }
  scene_path_ = last_path_ = path;
  workbench_.mark_saved();
  workbench_.notify(Severity::Note, tr("Saved %1").arg(path));
  emit name_changed();
  return true;
}

void FileActions::choose_and_save_labels() {
  QString path = local_path(QFileDialog::getSaveFileUrl(&window_, tr("Save the labels"),
                                                        url_of(suggested_path("-labels", ".nii.gz")),
                                                        tr("Label volumes (*.nii.gz *.nii *.seg.nrrd *.nrrd *.mha);;"
                                                           "DICOM segmentation, label map or contours "
                                                           "(*.dcm *.labelmap.dcm *.rtstruct.dcm)")));
  if (!path.isEmpty() && QFileInfo(path).suffix().isEmpty()) path += ".nii.gz";
  if (!path.isEmpty()) save_labels_to(path);
}

void FileActions::save_labels_to(const QString& path) {
  try {
    require_labels_name(to_path(path), workbench_.scene());
    require_writable_output(to_path(path));
  } catch (const std::exception& error) {
    workbench_.notify(Severity::Failure, QString::fromUtf8(error.what()));
    return;
  }
  const VolumeGeometry geometry = workbench_.session().volume().geometry();
  auto note = std::make_shared<std::string>();
  job_.start(
      tr("Saving %1...").arg(QFileInfo(path).fileName()),
      [=, scene = workbench_.session().scene(), file = to_path(path)] { *note = save_labels(file, scene, geometry); },
      [=, this] {
        const QString more = note->empty() ? QString() : "; " + QString::fromStdString(*note);
        workbench_.notify(Severity::Note, tr("Saved %1%2").arg(path, more));
      });
}

void FileActions::choose_and_save_meshes() {
  const QString one_file = tr(" (all in one file)");
  bool chosen = false;
  QString extension = QInputDialog::getItem(
      &window_, tr("Save the surfaces"), tr("File format (PLY is lossless):"),
      {".ply", ".obj", ".stl", ".vtk", ".vtp", ".3mf" + one_file, ".glb" + one_file}, 0, false, &chosen);
  if (!chosen) return;
  if (extension.endsWith(one_file)) {
    extension.chop(one_file.size());
    QString path = local_path(QFileDialog::getSaveFileUrl(&window_, tr("Save the surfaces"),
                                                          url_of(suggested_path("-surfaces", extension)),
                                                          tr("Surfaces (*%1)").arg(extension)));
    if (!path.isEmpty() && QFileInfo(path).suffix().isEmpty()) path += extension;
    if (!path.isEmpty()) save_surfaces_to(path);
    return;
  }
  const QString folder = local_path(QFileDialog::getExistingDirectoryUrl(
      &window_, tr("Folder for the surfaces, one file each"), url_of(usual_folder())));
  if (!folder.isEmpty()) save_meshes_to(folder, extension);
}

void FileActions::save_surfaces_to(const QString& path) {
  job_.start(
      tr("Saving %1...").arg(QFileInfo(path).fileName()),
      [scene = workbench_.session().scene(), file = to_path(path)] { save_surfaces(file, scene); },
      [=, this] { workbench_.notify(Severity::Note, tr("Saved %1").arg(path)); });
}

void FileActions::save_meshes_to(const QString& folder, const QString& extension) {
  job_.start(
      tr("Saving surfaces..."),
      [scene = workbench_.session().scene(), directory = to_path(folder), as = extension.toStdString()] {
        save_meshes(directory, scene, as);
      },
      [=, this] {
        const auto count = static_cast<std::int64_t>(workbench_.scene().meshes.size());
        workbench_.notify(Severity::Note, tr("Saved %1 to %2").arg(counted_text(count, "surface"), folder));
      });
}

QStringList FileActions::dropped_paths(const QMimeData* data) {
  QStringList paths;
  if (!data || !data->hasUrls()) return paths;
  for (const QUrl& url : data->urls())
    if (const QString path = local_path(url); !path.isEmpty()) paths << path;
  return paths;
}

}  // namespace simplexseg
