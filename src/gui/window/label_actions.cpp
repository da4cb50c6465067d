// SPDX-License-Identifier: Apache-2.0
#include "gui/window/label_actions.h"

#include <QAction>
#include <QFileDialog>
#include <QFileInfo>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <tuple>

#include "gui/input/action_table.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/window/file_actions.h"
#include "gui/window/label_dialog.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"
#include "image/rasterise.h"
#include "io/labels/label_file.h"
#include "io/platform/files.h"
#include "io/scene/mesh_start.h"

namespace simplexseg {
namespace {

/// Absolute path, so that a scene finds its labels from any working directory.
std::string absolute(const QString& path) {
  return std::filesystem::absolute(to_path(path)).lexically_normal().string();
}

const char* kLabelFilter =
    "Label volumes (*.nii *.nii.gz *.hdr *.nrrd *.nhdr *.seg.nrrd *.mha *.mhd *.gipl *.gipl.gz *.mnc *.dcm);;"
    "All files (*)";
const char* kMeshFilter = "Meshes (*.stl *.obj *.vtk *.vtp *.ply);;All files (*)";

/// Returns the label with the largest overlap for each mesh, in the order of the meshes; none without an overlap.
/// Labels are assigned by decreasing overlap, each to at most one mesh.
std::vector<std::optional<double>> labels_under(const std::vector<SimplexMesh>& meshes, const Volume& labels) {
  std::vector<std::tuple<std::size_t, std::size_t, double>> overlaps;  // number of voxels, index of the mesh, label
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const Mask mask = rasterise(meshes[m], labels.geometry());
    std::map<double, std::size_t> counts;
    visit_voxel_type(labels.type(), [&]<class T>(std::type_identity<T>) {
      const std::span<const T> voxels = labels.voxels<T>();
      for (std::size_t v = 0; v < voxels.size(); ++v)
        if (mask.voxels[v] && voxels[v] != T(0) && voxels[v] == voxels[v]) ++counts[static_cast<double>(voxels[v])];
    });
    for (const auto& [label, voxels] : counts) overlaps.emplace_back(voxels, m, label);
  }
  std::sort(overlaps.rbegin(), overlaps.rend());
  std::vector<std::optional<double>> result(meshes.size());
  for (const auto& [voxels, mesh, label] : overlaps) {
    const bool taken = std::any_of(result.begin(), result.end(), [l = label](const auto& has) { return has == l; });
    if (!taken && !result[mesh]) result[mesh] = label;
  }
  return result;
}

}  // namespace

struct LabelActions::Labels {
  std::shared_ptr<LabelFile> file;
  Volume volume;  ///< reference on the grid of the volume
  std::vector<LabelCount> counts;
  std::vector<std::string> warnings;
};

LabelActions::LabelActions(Workbench& workbench, BackgroundJob& job, FileActions& files, ActionTable& actions,
                           QWidget& window)
    : QObject(&window), workbench_(workbench), job_(job), files_(files), actions_(actions), window_(window) {
  const auto choose = [this](const QString& title, const char* filter) {
    return local_path(QFileDialog::getOpenFileUrl(&window_, title, url_of(files_.usual_folder()), filter));
  };
  actions.on(Act::MeshFromLabels, [=, this] {
    if (const QString path = choose(tr("Labels to import as segmentations"), kLabelFilter); !path.isEmpty())
      meshes_from_labels(path);
  });
  actions.on(Act::MeshFromFile, [=, this] {
    if (const QString path = choose(tr("Surface mesh to import"), kMeshFilter); !path.isEmpty()) mesh_from_file(path);
  });
  actions.on(Act::OpenReference, [=, this] {
    if (const QString path = choose(tr("Reference labels"), kLabelFilter); !path.isEmpty()) load_reference(path);
  });
  connect(&workbench_, &Workbench::scene_changed, this, &LabelActions::enable_actions);
  connect(&job_, &BackgroundJob::busy_changed, this, &LabelActions::enable_actions);
  enable_actions();
}

void LabelActions::enable_actions() {
  const bool volume = workbench_.has_volume(), meshes = !workbench_.scene().meshes.empty();
  const QString why_busy = tr("Wait until loading or saving has finished"), no_volume = tr("Open a volume first");
  for (const Act act : {Act::MeshFromLabels, Act::MeshFromFile})
    set_enabled(actions_[act], volume && !job_.busy(), volume ? why_busy : no_volume);
  const QString no_mesh = volume ? tr("There is no segmentation to compare yet") : no_volume;
  set_enabled(actions_[Act::OpenReference], meshes && !job_.busy(), meshes ? why_busy : no_mesh);
  set_enabled(actions_[Act::WorstFit], meshes, tr("There is no segmentation yet"));
}

void LabelActions::meshes_from_labels(const QString& path) {
  auto labels = std::make_shared<Labels>();
  job_.start(
      tr("Loading %1...").arg(QFileInfo(path).fileName()),
      [=, file = to_path(path)] {
        labels->file = std::make_shared<LabelFile>(file);
        labels->counts = labels->file->count();
        if (labels->counts.empty())
          choose_label(labels->file->labels().volume, {}, quoted(file));  // throws Error, because there is no label
      },
      [=, this] { choose_labels(path, labels); }, BackgroundJob::Cancellable::Yes);
}

void LabelActions::choose_labels(const QString& path, const std::shared_ptr<Labels>& labels) {
  auto* dialog = new LabelDialog(labels->counts, &window_);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  connect(dialog, &QDialog::accepted, this, [=, this] { make_meshes(path, labels, dialog->chosen()); });
  dialog->open();
}

void LabelActions::make_meshes(const QString& path, const std::shared_ptr<Labels>& labels,
                               const std::vector<LabelCount>& chosen) {
  auto starts = std::make_shared<std::vector<LoadedStart>>();
  job_.start(
      tr("Creating segmentations..."),
      [=, name = absolute(path)] {
        starts->reserve(chosen.size());
        for (const LabelCount& label : chosen) {
          const LabelChoice choice{label.value, 0};
          const LoadedLabels& loaded = labels->file->labels(choice);
          starts->push_back(start_of_labels(loaded.volume, choice, name));
          for (const std::string& warning : loaded.warnings) {
            if (std::find(labels->warnings.begin(), labels->warnings.end(), warning) == labels->warnings.end())
              labels->warnings.push_back(warning);
          }
        }
      },
      [=, this] {
        int made = 0;
        for (std::size_t n = 0; n < starts->size(); ++n) {
          std::string name = chosen[n].name;
          if (workbench_.scene().find_mesh(name)) name.clear();
          const LoadedStart& start = (*starts)[n];
          made += workbench_.apply(AddMesh{
              name, start.seed, chosen[n].colour, workbench_.view.active_mesh, start.start, {}, chosen[n].code});
        }
        if (made > 0) show_with_warnings(tr("Created %1").arg(counted_text(made, "segmentation")), labels->warnings);
      },
      BackgroundJob::Cancellable::Yes);
}

void LabelActions::show_with_warnings(QString text, const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) text += "; " + QString::fromStdString(warning);
  workbench_.notify(warnings.empty() ? Severity::Note : Severity::Warning, text);
}

void LabelActions::mesh_from_file(const QString& path) {
  auto start = std::make_shared<LoadedStart>();
  job_.start(
      tr("Loading %1...").arg(QFileInfo(path).fileName()),
      [=, file = to_path(path), name = absolute(path)] { *start = start_of_mesh(file, name); },
      [=, this] {
        std::string name = shown_path(QFileInfo(path).completeBaseName());
        if (workbench_.scene().find_mesh(name)) name.clear();
        workbench_.apply(AddMesh{name, start->seed, std::nullopt, workbench_.view.active_mesh, start->start});
      },
      BackgroundJob::Cancellable::Yes);
}

void LabelActions::load_reference(const QString& path) {
  auto labels = std::make_shared<Labels>();
  auto under = std::make_shared<std::vector<std::optional<double>>>();
  std::vector<SimplexMesh> meshes;
  std::vector<ItemId> ids;
  for (const MeshItem& item : workbench_.session().scene().meshes) {
    meshes.push_back(item.mesh);
    ids.push_back(item.id);
  }
  job_.start(
      tr("Loading %1...").arg(QFileInfo(path).fileName()),
      [=, file = to_path(path), geometry = workbench_.session().volume().geometry(), meshes = std::move(meshes)] {
        labels->file = std::make_shared<LabelFile>(file);
        labels->volume = labels->file->read_onto(geometry, "the volume", labels->warnings);
        count_labels(labels->volume, {});  // throws Error if the file is an image
        *under = labels_under(meshes, labels->volume);
      },
      [=, this, name = absolute(path)] {
        if (!workbench_.has_volume() || !workbench_.session().volume().geometry().same_grid(labels->volume.geometry()))
          return;
        workbench_.add_reference(name, labels->volume, labels->file);
        bool continues = false;
        int matched = 0;
        for (std::size_t m = 0; m < ids.size(); ++m) {
          if (!(*under)[m] || !workbench_.scene().find_mesh(ids[m])) continue;
          matched += workbench_.apply(SetReference{ids[m], Reference{name, (*under)[m]}, continues});
          continues = true;
        }
        QString text =
            matched == 0
                ? tr("No segmentation overlaps a label of %1. Choose a label in the row Reference of the panel Check.")
                : tr("Loaded %1: assigned a label to %2 of %3");
        text = text.arg(QFileInfo(path).fileName());
        if (matched > 0)
          text = text.arg(matched).arg(counted_text(static_cast<std::int64_t>(ids.size()), "segmentation"));
        show_with_warnings(text, labels->warnings);
      },
      BackgroundJob::Cancellable::Yes);
}

}  // namespace simplexseg
