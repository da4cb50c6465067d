// SPDX-License-Identifier: Apache-2.0
#include "gui/window/filter_actions.h"

#include <QAction>
#include <memory>

#include "gui/input/action_table.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/window/filter_dialog.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"
#include "io/registration/filters.h"
#include "io/volume/volume_checksum.h"

namespace simplexseg {
namespace {

/// Message after a change of filters.
QString filter_note(const QString& what, const std::vector<FilterStep>& filters) {
  return filters.empty() ? QObject::tr("%1 is shown without filters.").arg(what)
                         : QObject::tr("%1 is filtered: %2.").arg(what, text(describe(filters)));
}

}  // namespace

FilterActions::FilterActions(Workbench& workbench, BackgroundJob& job, ActionTable& actions, QWidget& window)
    : QObject(&window), workbench_(workbench), job_(job), actions_(actions), window_(window) {
  actions.on(Act::FilterLayer, [this] { ask_for_layer(); });
  actions.on(Act::FilterVolume, [this] { ask_for_volume(); });
  connect(&workbench_, &Workbench::scene_changed, this, &FilterActions::refresh);
  connect(&workbench_, &Workbench::view_changed, this, &FilterActions::refresh);
  connect(&job_, &BackgroundJob::busy_changed, this, &FilterActions::refresh);
  refresh();
}

void FilterActions::refresh() {
  const QString busy = tr("Wait until loading or saving has finished");
  const LayerItem* const layer = workbench_.scene().find_layer(workbench_.view.active_layer);
  const bool loaded = layer && workbench_.layer_images().image_of(*layer);
  set_enabled(actions_[Act::FilterLayer], loaded && !job_.busy(),
              !layer    ? tr("There is no layer yet: add one first")
              : !loaded ? tr("The image of the layer could not be read")
                        : busy);
  const bool volume = workbench_.has_volume();
  set_enabled(actions_[Act::FilterVolume], volume && !job_.busy(), volume ? busy : tr("Open a volume first"));
}

void FilterActions::ask_for_layer() {
  const LayerItem* const layer = workbench_.scene().find_layer(workbench_.view.active_layer);
  if (!layer) return;
  auto* dialog =
      new FilterDialog(tr("Filter layer '%1'").arg(text(layer->name)), layer->preprocessing.filters, false, &window_);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  connect(dialog, &QDialog::accepted, this, [this, dialog, id = layer->id] { filter_layer(id, dialog->filters()); });
  dialog->open();
}

void FilterActions::ask_for_volume() {
  auto* dialog = new FilterDialog(tr("Filter volume"), workbench_.scene().volume_preprocessing.filters, true, &window_);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  connect(dialog, &QDialog::accepted, this, [this, dialog] { filter_volume(dialog->filters()); });
  dialog->open();
}

void FilterActions::filter_layer(ItemId id, const std::vector<FilterStep>& filters) {
  const LayerItem* const layer = workbench_.scene().find_layer(id);
  if (!layer) return;
  LayerItem item = *layer;
  item.preprocessing = {filters, ""};
  const auto images = std::make_shared<LayerImages>(workbench_.layer_images());
  const auto checksum = std::make_shared<std::string>();
  job_.start(
      tr("Filtering layer '%1'...").arg(text(item.name)), [=] { *checksum = images->add_filtered(item); },
      [=, this] {
        workbench_.add_layer_images(*images);
        EditLayer edit{id};
        edit.preprocessing = Preprocessing{filters, filters.empty() ? std::string() : *checksum};
        if (workbench_.apply(edit))
          workbench_.notify(Severity::Note, filter_note(tr("Layer '%1'").arg(text(item.name)), filters));
      },
      BackgroundJob::Cancellable::Yes);
}

void FilterActions::filter_volume(const std::vector<FilterStep>& filters) {
  struct Result {
    FilteredVolumes volumes;
    Volume volume;
    std::string checksum;
  };
  const auto result = std::make_shared<Result>();
  result->volumes = workbench_.session().volumes();
  job_.start(
      tr("Filtering the volume..."),
      [=] {
        result->volume = result->volumes.get(filters);
        if (!filters.empty()) result->checksum = checksum_of(result->volume);
      },
      [=, this] {
        workbench_.add_volumes({{filters, result->volume}});
        if (workbench_.apply(FilterVolume{{filters, result->checksum}}))
          workbench_.notify(Severity::Note, filter_note(tr("The volume"), filters));
      },
      BackgroundJob::Cancellable::Yes);
}

}  // namespace simplexseg
