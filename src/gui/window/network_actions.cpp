// SPDX-License-Identifier: Apache-2.0
#include "gui/window/network_actions.h"

#include <QAction>
#include <QWidget>

#include "gui/input/action_table.h"
#include "gui/input/key_map.h"
#include "gui/look/widgets.h"
#include "gui/window/network_dialog.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

NetworkActions::NetworkActions(Workbench& workbench, ActionTable& actions, QWidget& window)
    : QObject(&window), workbench_(workbench), actions_(actions), window_(window), job_(new BackgroundJob(this)) {
  actions.on(Act::NetworkStart, [this] { ask(); });
  connect(&workbench_, &Workbench::scene_changed, this, &NetworkActions::refresh);
  connect(&workbench_, &Workbench::volume_changed, this, &NetworkActions::refresh);
  refresh();
}

NetworkActions::~NetworkActions() { delete dialog_; }

void NetworkActions::refresh() {
  const MeshItem* const active = workbench_.active_mesh();
  QString why;
  if (!workbench_.has_volume())
    why = tr("Open a volume first");
  else if (!active)
    why = tr("There is no segmentation yet: place a seed first (%1)").arg(key_hint(Act::ToolSeed));
  else if (active->locked)
    why = why_locked();
  else if (active->model)
    why = tr("This segmentation has a model: remove it first");
  else if (active->start && !active->start->network)
    why = tr("This segmentation starts from labels or a mesh: start one from a seed to use a network");
  set_enabled(actions_[Act::NetworkStart], why.isEmpty(), why);
}

void NetworkActions::ask() {
  dialog_ = new NetworkDialog(workbench_, workbench_.view.active_mesh, *job_, &window_);
  dialog_->setAttribute(Qt::WA_DeleteOnClose);
  dialog_->open();
}

}  // namespace simplexseg
