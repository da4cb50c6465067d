// SPDX-License-Identifier: Apache-2.0
#include "gui/window/layer_actions.h"

#include <QAction>
#include <QActionGroup>
#include <QFileDialog>
#include <QFileInfo>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <numeric>

#include "core/error.h"
#include "gui/input/action_table.h"
#include "gui/look/qt_text.h"
#include "gui/look/slice_geometry.h"
#include "gui/look/widgets.h"
#include "gui/window/file_actions.h"
#include "gui/window/register_dialog.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"
#include "io/platform/files.h"
#include "io/platform/load_progress.h"
#include "io/scene/layer_file.h"
#include "io/transform/transform_io.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

const char* kImageFilter =
    "Volumes (*.nii *.nii.gz *.hdr *.img *.nrrd *.nhdr *.mha *.mhd *.gipl *.gipl.gz *.mnc *.dcm);;All files (*)";
const char* kReadFilter = "Transforms (*.tfm *.txt *.mat *.h5 *.nii *.nii.gz);;All files (*)";

/// Whether the boxes around two images overlap.
bool overlap(const VolumeGeometry& a, const VolumeGeometry& b) {
  const WorldBox first = world_box(a), second = world_box(b);
  return (first.low_mm.array() < second.high_mm.array()).all() && (second.low_mm.array() < first.high_mm.array()).all();
}

/// Result of a registration as a transform of a layer; a displacement field is written to `field_path` and read again,
/// so that a scene that is opened later has the same bits.
LayerTransform stored_transform(const Transform& found, const std::filesystem::path& field_path, LayerImages& images) {
  LayerTransform stored;
  Transform after;
  for (const Transform::Step& step : found.steps()) {
    if (const auto* const field = std::get_if<DisplacementField>(&step)) {
      write_field(field_path, *field);
      Transform read;
      stored = load_layer_transform(field_path, read);
      images.add_transform(stored, read);
    } else {
      after.append(std::get<Eigen::Affine3d>(step));
    }
  }
  stored.affine = after.affine().value_or(Eigen::Affine3d::Identity());
  return stored;
}

}  // namespace

LayerActions::LayerActions(Workbench& workbench, BackgroundJob& job, FileActions& files, ActionTable& actions,
                           QWidget& window)
    : QObject(&window), workbench_(workbench), job_(job), files_(files), actions_(actions), window_(window) {
  actions.on(Act::AddLayer, [this] {
    const QString path = local_path(QFileDialog::getOpenFileUrl(&window_, tr("Image to show over the volume"),
                                                                url_of(files_.usual_folder()), kImageFilter));
    if (!path.isEmpty()) add(path);
  });
  actions.on(Act::AddLayerFolder, [this] {
    const QString path = local_path(QFileDialog::getExistingDirectoryUrl(
        &window_, tr("DICOM folder to show over the volume"), url_of(files_.usual_folder())));
    if (!path.isEmpty()) add(path);
  });
  actions.on(Act::RegisterLayer, [this] { ask_registration(); });
  actions.on(Act::LoadTransform, [this] {
    const QString path = local_path(QFileDialog::getOpenFileUrl(&window_, tr("Transform of the layer"),
                                                                url_of(files_.usual_folder()), kReadFilter));
    if (!path.isEmpty()) load_transform(path);
  });
  actions.on(Act::SaveTransform, [this] {
    const QString path = local_path(QFileDialog::getSaveFileUrl(&window_, tr("Save the transform of the layer"),
                                                                url_of(files_.suggested_path("-transform", ".tfm")),
                                                                tr("Transforms of ITK (*.tfm *.txt)")));
    if (!path.isEmpty()) save_transform(path);
  });
  actions.on(Act::RemoveLayer, [this] {
    if (active()) workbench_.apply(RemoveLayer{active()->id});
  });
  connect_display();
  connect(&workbench_, &Workbench::scene_changed, this, &LayerActions::refresh);
  connect(&workbench_, &Workbench::view_changed, this, &LayerActions::refresh);
  connect(&job_, &BackgroundJob::busy_changed, this, &LayerActions::refresh);
  refresh();
}

void LayerActions::connect_display() {
  auto* group = new QActionGroup(this);
  for (const auto& [act, mode] : {std::pair{Act::LayerBlend, LayerMode::Blend},
                                  {Act::LayerCheckerboard, LayerMode::Checkerboard},
                                  {Act::LayerSwipe, LayerMode::Swipe}}) {
    actions_.on_toggle(act, [this, mode = mode](bool) {
      workbench_.view.layer_mode = mode;
      workbench_.view.show_layers = true;
      workbench_.view_edited();
    });
    group->addAction(actions_[act]);
  }
  actions_.on_toggle(Act::ShowLayers, [this](bool shown) {
    workbench_.view.show_layers = shown;
    workbench_.view_edited();
  });
  actions_.on_toggle(Act::LayerContrast, [this](bool armed) {
    workbench_.view.layer_contrast_armed = armed;
    workbench_.view_edited();
  });
  for (const Act act : {Act::ShowLayers, Act::LayerContrast}) actions_[act]->setAutoRepeat(false);
}

void LayerActions::fill(QMenu& menu) {
  menu.setToolTipsVisible(true);
  const std::initializer_list<Act> groups[] = {
      {Act::AddLayer, Act::AddLayerFolder, Act::RemoveLayer},
      {Act::RegisterLayer, Act::LoadTransform, Act::SaveTransform},
      {Act::FilterLayer, Act::FilterVolume},
      {Act::LayerBlend, Act::LayerCheckerboard, Act::LayerSwipe, Act::ShowLayers, Act::LayerContrast}};
  for (const auto& group : groups) {
    if (!menu.isEmpty()) menu.addSeparator();
    for (const Act act : group) menu.addAction(actions_[act]);
  }
}

const LayerItem* LayerActions::active() const { return workbench_.scene().find_layer(workbench_.view.active_layer); }

void LayerActions::refresh() {
  const bool volume = workbench_.has_volume();
  const QString no_volume = tr("Open a volume first"), busy = tr("Wait until loading or saving has finished");
  for (const Act act : {Act::AddLayer, Act::AddLayerFolder})
    set_enabled(actions_[act], volume && !job_.busy(), volume ? busy : no_volume);
  const LayerItem* const layer = active();
  const QString none = tr("There is no layer yet: add one first");
  for (const Act act : {Act::RemoveLayer, Act::SaveTransform, Act::LayerBlend, Act::LayerCheckerboard, Act::LayerSwipe,
                        Act::ShowLayers, Act::LayerContrast})
    set_enabled(actions_[act], layer != nullptr, none);
  const bool loaded = layer && workbench_.layer_images().image_of(*layer);
  set_enabled(actions_[Act::LoadTransform], layer && !job_.busy(), layer ? busy : none);
  set_enabled(actions_[Act::RegisterLayer], loaded && !job_.busy(),
              !layer    ? none
              : !loaded ? tr("The image of the layer could not be read")
                        : busy);
  const ViewState& view = workbench_.view;
  const Act mode = view.layer_mode == LayerMode::Blend          ? Act::LayerBlend
                   : view.layer_mode == LayerMode::Checkerboard ? Act::LayerCheckerboard
                                                                : Act::LayerSwipe;
  actions_[mode]->setChecked(true);
  actions_[Act::ShowLayers]->setChecked(view.show_layers);
  actions_[Act::LayerContrast]->setChecked(view.layer_contrast_armed);
}

void LayerActions::add(const QString& path) {
  auto added = std::make_shared<LayerFile>();
  const VolumeGeometry volume = workbench_.session().volume().geometry();
  job_.start(
      tr("Loading %1...").arg(QFileInfo(path).fileName()), [=, file = to_path(path)] { *added = read_layer(file); },
      [=, this] {
        LayerItem& item = added->item;
        LayerImages images;
        images.add_image(item, added->image);
        workbench_.add_layer_images(images);
        if (!workbench_.apply(AddLayer{item})) return;
        if (!overlap(volume, added->image->geometry()))
          added->warnings.push_back(tr("Layer '%1' lies outside the volume: register it to bring it there")
                                        .arg(text(item.name))
                                        .toStdString());
        for (const std::string& warning : added->warnings) workbench_.notify(Severity::Warning, text(warning));
      },
      BackgroundJob::Cancellable::Yes);
}

void LayerActions::ask_registration() {
  const LayerItem* const layer = active();
  const auto* const shown = window_.findChild<RegisterDialog*>();
  if (!layer || (shown && shown->isVisible())) return;
  auto* dialog = new RegisterDialog(workbench_, *layer, &window_);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  connect(dialog, &QDialog::accepted, this, [this, dialog, id = layer->id] {
    const RegistrationSettings settings = dialog->settings();
    const Landmarks landmarks = dialog->landmarks();
    QString field;
    if (settings.kind == RegistrationKind::Displacement) {
      field = local_path(QFileDialog::getSaveFileUrl(&window_, tr("Save the displacement field"),
                                                     url_of(files_.suggested_path("-field", ".nii.gz")),
                                                     tr("Displacement fields (*.nii.gz *.nii)")));
      if (field.isEmpty()) return;
    }
    register_layer(id, settings, field, landmarks);
  });
  dialog->show();  // not modal: landmarks are placed in the slices
}

void LayerActions::register_layer(ItemId id, const RegistrationSettings& settings, const QString& field_path,
                                  const Landmarks& landmarks) {
  const LayerItem* const layer = workbench_.scene().find_layer(id);
  const std::shared_ptr<const Volume> moving = layer ? workbench_.layer_images().image_of(*layer) : nullptr;
  if (!moving) return;
  struct Found {
    RegistrationResult result;
    LayerTransform transform;
    LayerImages images;
    JacobianRange jacobian;
  };
  auto found = std::make_shared<Found>();
  const QString name = text(layer->name);
  job_.start(
      tr("Registering layer '%1'...").arg(name),
      [=, fixed = workbench_.session().volume(), field = to_path(field_path)] {
        if (settings.kind == RegistrationKind::Displacement) require_field_name(field);
        found->result = register_images(fixed, *moving, settings,
                                        [](const RegistrationProgress& state) { report_progress(state.done, 1); });
        found->jacobian = jacobian_range(found->result.transform, fixed.geometry());
        found->transform = stored_transform(found->result.transform, field, found->images);
      },
      [=, this] {
        workbench_.add_layer_images(found->images);
        QString note = tr("Registered layer '%1': mutual information %2 before, %3 after. Check the result by a swipe.")
                           .arg(name)
                           .arg(-found->result.metric_before, 0, 'f', 3)
                           .arg(-found->result.metric_after, 0, 'f', 3);
        if (settings.kind == RegistrationKind::Displacement)
          note += tr(" Volumes change by factors from %1 to %2; the field folds at %3% of the voxels.")
                      .arg(found->jacobian.min, 0, 'f', 2)
                      .arg(found->jacobian.max, 0, 'f', 2)
                      .arg(100 * found->jacobian.folded_share, 0, 'f', 2);
        if (const std::vector<double> residuals = residuals_mm(found->result.transform, landmarks); !residuals.empty())
          note += tr(" Landmarks: residual %1 mm on average, %2 mm at most.")
                      .arg(std::reduce(residuals.begin(), residuals.end()) / static_cast<double>(residuals.size()), 0,
                           'f', 1)
                      .arg(*std::max_element(residuals.begin(), residuals.end()), 0, 'f', 1);
        set_transform(id, found->transform, note);
      },
      BackgroundJob::Cancellable::Yes);
}

void LayerActions::set_transform(ItemId layer, const LayerTransform& transform, const QString& note) {
  EditLayer edit{layer};
  edit.transform = transform;
  if (workbench_.apply(edit)) workbench_.notify(Severity::Note, note);
}

void LayerActions::load_transform(const QString& path) {
  struct Read {
    LayerTransform stored;
    Transform transform;
  };
  const LayerItem* const layer = active();
  if (!layer) return;
  auto read = std::make_shared<Read>();
  job_.start(
      tr("Loading %1...").arg(QFileInfo(path).fileName()),
      [=, file = to_path(path)] { read->stored = load_layer_transform(file, read->transform); },
      [=, this, id = layer->id, name = text(layer->name)] {
        LayerImages images;
        if (!read->stored.file.empty()) images.add_transform(read->stored, read->transform);
        workbench_.add_layer_images(images);
        set_transform(id, read->stored, tr("Layer '%1' has the transform of %2").arg(name, QFileInfo(path).fileName()));
      },
      BackgroundJob::Cancellable::Yes);
}

void LayerActions::save_transform(const QString& path) {
  const LayerItem* const layer = active();
  if (!layer) return;
  try {
    write_transform(to_path(path), Transform(layer->transform.affine));
    workbench_.notify(Severity::Note,
                      layer->transform.file.empty()
                          ? tr("Saved the transform to %1").arg(QFileInfo(path).fileName())
                          : tr("Saved the affine transform to %1. The displacement field that acts before it is %2.")
                                .arg(QFileInfo(path).fileName(), text(layer->transform.file)));
  } catch (const Error& error) {
    workbench_.notify(Severity::Failure, QString::fromUtf8(error.what()));
  }
}

}  // namespace simplexseg
