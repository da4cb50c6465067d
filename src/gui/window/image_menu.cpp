// SPDX-License-Identifier: Apache-2.0
#include "gui/window/image_menu.h"

#include <QActionGroup>
#include <algorithm>

#include "gui/input/key_map.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

ImageMenu::ImageMenu(Workbench& workbench, QWidget* parent)
    : QMenu(tr("Computed on &images"), parent), workbench_(workbench), main_(new QActionGroup(this)) {
  setObjectName("image_menu");
  setToolTipsVisible(true);
  connect(&workbench_, &Workbench::scene_changed, this, &ImageMenu::refresh);
  connect(this, &QMenu::aboutToShow, this, &ImageMenu::refresh);
  refresh();
}

void ImageMenu::add(std::uint32_t image, const QString& name) {
  const MeshItem* const item = workbench_.active_mesh();
  const QString title = QString(name).replace("&", "&&"), id = QString::number(image);
  QAction* const main = addAction(title);
  main->setObjectName("main_image_" + id);
  main->setCheckable(true);
  main->setActionGroup(main_);
  main->setChecked(item->images.main == image);
  main->setToolTip(tr("Edges and surface are found in this image"));
  connect(main, &QAction::triggered, this, [this, image] {
    MeshImages images = workbench_.active_mesh()->images;
    std::erase(images.further, image);
    images.main = image;
    set(images);
  });
}

void ImageMenu::refresh() {
  clear();
  const MeshItem* const item = workbench_.active_mesh();
  const std::vector<LayerItem>& layers = workbench_.scene().layers;
  const QString why = !item ? tr("There is no segmentation yet: place a seed first (%1)").arg(key_hint(Act::ToolSeed))
                      : item->locked     ? why_locked()
                      : item->is_given() ? tr("This segmentation starts from labels or a mesh, which uses no image")
                      : layers.empty()   ? tr("There is one image: add a layer first (%1)").arg(key_hint(Act::AddLayer))
                                         : QString();
  set_enabled(menuAction(), why.isEmpty(), why);
  if (!why.isEmpty()) return;
  addSection(tr("Main image"));
  add(0, tr("Volume"));
  for (const LayerItem& layer : layers) add(layer.id, text(layer.name));
  addSection(tr("Further images"));
  const auto add_further = [&](std::uint32_t image, const QString& name) {
    if (item->images.main == image) return;
    QAction* const also = addAction(QString(name).replace("&", "&&"));
    also->setObjectName("further_image_" + QString::number(image));
    also->setCheckable(true);
    also->setChecked(item->images.uses(image));
    also->setToolTip(
        tr("Its intensities inform the segmentation in addition, mainly before the first corrections. An "
           "image in which the object cannot be seen makes it worse"));
    connect(also, &QAction::triggered, this, [this, image](bool on) {
      MeshImages images = workbench_.active_mesh()->images;
      std::erase(images.further, image);
      if (on) images.further.push_back(image);
      set(images);
    });
  };
  add_further(0, tr("Volume"));
  for (const LayerItem& layer : layers) add_further(layer.id, text(layer.name));
}

void ImageMenu::set(const MeshImages& images) { workbench_.apply(SetImages{workbench_.view.active_mesh, images}); }

}  // namespace simplexseg
