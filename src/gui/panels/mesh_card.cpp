// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/mesh_card.h"

#include <QApplication>
#include <QColorDialog>
#include <QEvent>
#include <QFileInfo>
#include <QHBoxLayout>
#include <QLabel>
#include <QMenu>
#include <QMouseEvent>
#include <QSignalBlocker>
#include <QSlider>
#include <QSpinBox>
#include <QStyle>
#include <QToolButton>
#include <QVBoxLayout>
#include <cmath>
#include <utility>

#include "core/number_text.h"
#include "gui/input/action_table.h"
#include "gui/look/integer_box.h"
#include "gui/look/qt_text.h"
#include "gui/look/symbols.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/panels/mode_sliders.h"
#include "gui/workbench/name_line.h"
#include "gui/workbench/naming.h"
#include "gui/workbench/workbench.h"
#include "io/platform/files.h"
#include "model/organ_model.h"

namespace simplexseg {
namespace {

QToolButton* flat_button(const QString& name, QWidget* parent) {
  auto* button = new QToolButton(parent);
  button->setAutoRaise(true);
  button->setAccessibleName(name);
  button->setToolTip(name);
  set_role(button, "flat");
  return button;
}

}  // namespace

MeshCard::MeshCard(Workbench& workbench, ActionTable& actions, QWidget* parent)
    : QFrame(parent), workbench_(workbench) {
  setObjectName("mesh_card");
  auto* rows = new QVBoxLayout(this);
  rows->setContentsMargins(6, 4, 4, 4);
  rows->setSpacing(2);
  build_upper_row(actions);
  build_lower_row();
  for (QWidget* part : findChildren<QWidget*>()) part->installEventFilter(this);
}

void MeshCard::build_upper_row(ActionTable& actions) {
  colour_ = flat_button(tr("Colour"), this);
  name_ = new NameLine([this] { return offered_labels(workbench_.scene()); }, this);
  name_->setFrame(false);
  set_role(name_, "title");
  name_->setAccessibleName(tr("Name"));
  cancel_ = flat_button(tr("Cancel"), this);
  cancel_->setObjectName("cancel_solving");
  cancel_->setText(QString(QChar(0x00d7)));
  cancel_->setToolTip(tr("Cancel (Esc)"));
  cancel_->hide();
  solve_ = new QToolButton(this);
  solve_->setObjectName("solve");
  solve_->setText(tr("Solve"));
  solve_->setToolTip(tr("Apply the marks that are not applied yet"));
  solve_->hide();
  shown_ = flat_button(tr("Shown in the views"), this);
  shown_->setCheckable(true);
  locked_ = flat_button(tr("Locked: the segmentation does not change"), this);
  locked_->setCheckable(true);
  auto* menu_button = flat_button(tr("Menu of this segmentation"), this);
  menu_button->setIcon(icon_of(Symbol::Menu));
  menu_button->setPopupMode(QToolButton::InstantPopup);
  auto* menu = new QMenu(menu_button);
  menu->setToolTipsVisible(true);
  for (const Act act :
       {Act::NameMesh, Act::ResetMesh, Act::RefineMesh, Act::RecordProfiles, Act::LockMesh, Act::DuplicateMesh})
    menu->addAction(actions[act]);
  menu->addSeparator();
  for (const Act act : {Act::MeshUp, Act::MeshDown, Act::DeleteMesh}) menu->addAction(actions[act]);
  menu_button->setMenu(menu);
  auto* row = new QHBoxLayout;
  row->setSpacing(2);
  row->addWidget(colour_);
  row->addWidget(name_, 1);
  for (QToolButton* button : {cancel_, solve_, shown_, locked_, menu_button}) row->addWidget(button);
  static_cast<QVBoxLayout*>(layout())->addLayout(row);

  connect(colour_, &QToolButton::clicked, this, &MeshCard::choose_colour);
  connect(name_, &QLineEdit::editingFinished, this, [this] {
    const MeshItem* item = workbench_.scene().find_mesh(mesh_);
    const std::string name = name_->text().trimmed().toStdString();
    if (item && name != item->name) edit(naming_command(workbench_.scene(), mesh_, name));
  });
  connect(name_, &NameLine::chosen, this,
          [this](const PresetLabel& label) { edit(naming_command(workbench_.scene(), mesh_, label)); });
  connect(cancel_, &QToolButton::clicked, this, [this] {
    if (workbench_.session().solving_mesh() == mesh_) workbench_.cancel_solving();
  });
  connect(solve_, &QToolButton::clicked, this, [this] { workbench_.solve(mesh_); });
  connect(shown_, &QToolButton::clicked, this, [this](bool shown) { edit({mesh_, {}, {}, shown, {}}); });
  connect(locked_, &QToolButton::clicked, this, [this](bool locked) { edit({mesh_, {}, {}, {}, {}, locked}); });
}

void MeshCard::build_lower_row() {
  label_ = new IntegerBox(this);
  label_->setRange(1, 65535);
  label_->setFrame(false);
  label_->setButtonSymbols(QAbstractSpinBox::NoButtons);
  label_->setKeyboardTracking(false);
  label_->setPrefix(tr("label "));
  label_->setFixedWidth(label_->fontMetrics().horizontalAdvance(tr("label ") + "65535") + 10);
  set_role(label_, "title");
  label_->setAccessibleName(tr("Label"));
  label_->setToolTip(tr("Value of the voxels of this segmentation in saved labels"));
  opacity_ = new QSlider(Qt::Horizontal, this);
  opacity_->setRange(10, 100);
  opacity_->setTracking(false);  // each drag is one undo step
  opacity_->setFixedWidth(theme::scaled(58));
  opacity_->setAccessibleName(tr("Opacity"));
  opacity_->setToolTip(tr("Opacity in the 3D view"));
  volume_ = new QLabel(this);
  volume_->setToolTip(tr("Volume; not shown while the surface moves"));
  state_ = new QLabel(this);
  state_->setAlignment(Qt::AlignRight | Qt::AlignVCenter);
  auto* row = new QHBoxLayout;
  row->setSpacing(6);
  row->addWidget(label_);
  row->addWidget(opacity_);
  row->addWidget(volume_);
  row->addWidget(state_, 1);
  static_cast<QVBoxLayout*>(layout())->addLayout(row);
  prior_ = new QLabel(this);
  prior_->setObjectName("card_prior");
  prior_->setTextFormat(Qt::PlainText);
  set_role(prior_, "dim");
  prior_->hide();
  layout()->addWidget(prior_);
  images_ = new QLabel(this);
  images_->setObjectName("card_images");
  set_role(images_, "dim");
  images_->hide();
  layout()->addWidget(images_);
  modes_ = new ModeSliders(workbench_, this);
  modes_->hide();
  layout()->addWidget(modes_);

  connect(label_, &QSpinBox::valueChanged, this, [this](int label) { edit({mesh_, {}, {}, {}, label}); });
  connect(opacity_, &QSlider::valueChanged, this, [this](int percent) {
    edit({mesh_, {}, {}, {}, {}, {}, static_cast<float>(percent) / 100});
  });
}

void MeshCard::edit(const EditMesh& change) {
  if (workbench_.apply(change)) return;
  name_->setModified(false);
  if (const MeshItem* item = workbench_.scene().find_mesh(mesh_))
    show_mesh(*item, mesh_ == workbench_.view.active_mesh);
}

void MeshCard::show_mesh(const MeshItem& item, bool active) {
  mesh_ = item.id;
  const QSignalBlocker label_blocker(label_), opacity_blocker(opacity_);
  colour_->setIcon(swatch(item.colour, active));
  const QString name = QString::fromStdString(item.name);
  const bool being_typed = name_->hasFocus() && name_->isModified();
  if (!being_typed && name_->text() != name) name_->setText(name);
  const QString code = text_of_code(code_of(item));
  name_->setToolTip(tr("Name: click to change it\nDICOM code: %1").arg(code));
  shown_->setChecked(item.visible);
  shown_->setIcon(icon_of(item.visible ? Symbol::Shown : Symbol::Hidden));
  locked_->setChecked(item.locked);
  locked_->setIcon(icon_of(item.locked ? Symbol::Locked : Symbol::Unlocked));
  label_->setValue(item.label);
  opacity_->setValue(static_cast<int>(std::lround(item.opacity * 100)));
  show_prior(item);
  images_->setVisible(!item.images.is_default());
  if (!item.images.is_default()) {
    const auto name_of = [&](ItemId image) {
      const LayerItem* const layer = workbench_.scene().find_layer(image);
      return layer ? text(layer->name) : tr("Volume");
    };
    QStringList further;
    for (const ItemId image : item.images.further) further << name_of(image);
    images_->setText(further.empty()
                         ? tr("Computed on: %1").arg(name_of(item.images.main))
                         : tr("Computed on: %1, with %2").arg(name_of(item.images.main), further.join(", ")));
    images_->setToolTip(tr("Images in which this segmentation is computed: Segmentation > Computed on images"));
  }
  modes_->setVisible(active && item.model);
  if (item.model) modes_->show_mesh(item);
  if (property("active").toBool() != active) {
    setProperty("active", active);
    style()->unpolish(this);
    style()->polish(this);
  }
}

void MeshCard::show_prior(const MeshItem& item) {
  const NetworkMask* const network = item.start ? item.start->network.get() : nullptr;
  prior_->setVisible(network || item.model);
  if (prior_->isHidden()) return;
  QString prior;
  if (network) {
    prior = tr("Network: %1").arg(text(one_line(network->network, 40)));
    const QString tip =
        tr("Start and prior from a mask of %1. Licence of the weights: %2. Trust: share of its shape in "
           "the segmentation, which image and marks correct.")
            .arg(text(network->server), network->licence.empty() ? tr("not stated") : text(network->licence));
    prior_->setToolTip("<p>" + tip.toHtmlEscaped() + "</p>");  // texts of a server are no markup
  } else {
    const OrganModel& organ = *item.model->organ;
    const QString file = QFileInfo(text(std::filesystem::path(item.model->path))).fileName();
    prior = tr("Model: %1").arg(organ.name.empty() ? file : text(organ.name));
    prior_->setToolTip(
        tr("%1: %2, error on unseen cases %3.\nTrust: share of its shape in the segmentation. A model has no "
           "effect where it does not fit the image.")
            .arg(file, counted_text(static_cast<std::int64_t>(organ.cases.size()), "case"),
                 text(length_text(organ.surface_error_mm))));
  }
  const bool solved = item.field && item.field->model == item.prior_identity() && !item.field->is_preliminary();
  if (!solved)
    prior_->setText(prior);
  else if (item.field->model_trust > 0)
    prior_->setText(tr("%1, trust %2%").arg(prior, QString::number(std::lround(100 * item.field->model_trust))));
  else
    prior_->setText(tr("%1, no effect here").arg(prior));
}

void MeshCard::show_state(const QString& state, bool is_warning, const QString& advice) {
  state_->setText(state);
  if (state_->toolTip() != advice) state_->setToolTip(advice);
  set_role(state_, is_warning ? "warning" : "dim");
}

void MeshCard::show_update(bool solving, bool pending) {
  cancel_->setVisible(solving);
  solve_->setVisible(pending && !solving);
}

void MeshCard::show_volume(std::optional<double> mm3) { volume_->setText(mm3 ? text(volume_text(*mm3)) : QString()); }

// A press on a control does not reach the card, so this filter makes the mesh active.
bool MeshCard::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() == QEvent::MouseButtonPress || event->type() == QEvent::FocusIn) workbench_.set_active_mesh(mesh_);
  // The wheel scrolls the list; it changes a value only if the control has the focus.
  if (event->type() == QEvent::Wheel && (watched == label_ || qobject_cast<QSlider*>(watched)) &&
      !static_cast<QWidget*>(watched)->hasFocus()) {
    event->ignore();
    return true;
  }
  return QFrame::eventFilter(watched, event);
}

void MeshCard::mousePressEvent(QMouseEvent* event) {
  workbench_.set_active_mesh(mesh_);
  pressed_at_ = event->globalPosition();
  event->accept();
}

void MeshCard::mouseMoveEvent(QMouseEvent* event) {
  const bool far = (event->globalPosition() - pressed_at_).manhattanLength() >= QApplication::startDragDistance();
  if (!(event->buttons() & Qt::LeftButton) || !(dragged_ || far)) return;
  dragged_ = true;
  setCursor(Qt::ClosedHandCursor);
  emit dragged(event->globalPosition().toPoint());
}

void MeshCard::mouseReleaseEvent(QMouseEvent* event) {
  if (!std::exchange(dragged_, false)) return;
  unsetCursor();
  emit dropped(event->globalPosition().toPoint());
}

void MeshCard::choose_colour() {
  const MeshItem* item = workbench_.scene().find_mesh(mesh_);
  if (!item) return;
  const QColor chosen = QColorDialog::getColor(QColor(item->colour.red, item->colour.green, item->colour.blue), this,
                                               tr("Colour of %1").arg(QString::fromStdString(item->name)));
  if (!chosen.isValid()) return;
  const auto channel = [](int value) { return static_cast<std::uint8_t>(value); };
  edit({mesh_, {}, Colour{channel(chosen.red()), channel(chosen.green()), channel(chosen.blue())}, {}, {}});
}

}  // namespace simplexseg
