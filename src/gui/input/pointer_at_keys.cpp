// SPDX-License-Identifier: Apache-2.0
#include "gui/input/pointer_at_keys.h"

#include <QApplication>
#include <QKeyEvent>
#include <QMouseEvent>
#include <QOpenGLWidget>
#include <QWidget>
#include <QWindow>
#include <algorithm>
#include <cstdint>
#include <cstring>

#include "gui/input/focus_return.h"

namespace simplexseg {
namespace {

constexpr std::size_t kMostPresses = 64;
constexpr std::uint8_t kKeyPress = 2, kSent = 0x80;  // event codes of the X11 protocol

/// Key event of the X11 protocol.
struct X11KeyEvent {
  std::uint8_t code, key;
  std::uint16_t sequence;
  std::uint32_t time_ms, root, window, inner_window;
  std::int16_t root_x, root_y, x, y;
  std::uint16_t state;
  std::uint8_t same_screen, unused;
};
static_assert(sizeof(X11KeyEvent) == 32);

}  // namespace

PointerAtKeys::PointerAtKeys(QObject* parent) : QObject(parent) {
  qApp->installNativeEventFilter(this);
  qApp->installEventFilter(this);
}

PointerAtKeys::~PointerAtKeys() {
  if (qApp) qApp->removeNativeEventFilter(this);
}

bool PointerAtKeys::nativeEventFilter(const QByteArray& type, void* message, qintptr*) {
  if (type != "xcb_generic_event_t") return false;
  X11KeyEvent event;
  std::memcpy(&event.code, message, sizeof event.code);
  if ((event.code & ~kSent) != kKeyPress) return false;
  std::memcpy(&event, message, sizeof event);
  presses_.push_back({event.time_ms, {event.x, event.y}});
  if (presses_.size() > kMostPresses) presses_.pop_front();
  return false;
}

bool PointerAtKeys::eventFilter(QObject* watched, QEvent* event) {
  if (!watched->isWindowType()) return false;
  QWindow& window = static_cast<QWindow&>(*watched);
  switch (event->type()) {
    case QEvent::MouseMove:
    case QEvent::MouseButtonPress:
    case QEvent::Enter:
      window_ = &window;
      at_ = static_cast<QSinglePointEvent*>(event)->position();
      break;
    case QEvent::Leave:
      window_ = nullptr;
      break;
    case QEvent::ShortcutOverride:  // precedes the shortcuts of the menus
    case QEvent::KeyPress:
      move_pointer(window, static_cast<const QInputEvent&>(*event));
      break;
    default:
      break;
  }
  return false;
}

void PointerAtKeys::move_pointer(QWindow& window, const QInputEvent& key) {
  const auto press = std::find_if(presses_.rbegin(), presses_.rend(),
                                  [&](const Press& one) { return one.time_ms == key.timestamp(); });
  // Without an earlier movement in the window, the pointer has not been used there.
  if (press == presses_.rend() || window_ != &window || QApplication::mouseButtons() != Qt::NoButton) return;
  const QPointF at = QPointF(press->pixel) / window.devicePixelRatio();
  if ((at - at_).manhattanLength() < 1) return;
  QWidget* const top = QWidget::find(window.winId());
  QWidget* const under = top ? top->childAt(at.toPoint()) : nullptr;
  if (!qobject_cast<QOpenGLWidget*>(under)) return;
  at_ = at;
  if (!is_typing()) under->setFocus(Qt::MouseFocusReason);  // as when the pointer enters the view
  QMouseEvent move(QEvent::MouseMove, under->mapFrom(top, at), window.mapToGlobal(at), Qt::NoButton, Qt::NoButton,
                   key.modifiers());
  QApplication::sendEvent(under, &move);
}

}  // namespace simplexseg
