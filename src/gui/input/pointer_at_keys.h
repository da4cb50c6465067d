// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QAbstractNativeEventFilter>
#include <QObject>
#include <QPoint>
#include <QPointF>
#include <deque>

class QInputEvent;
class QWindow;

namespace simplexseg {

/// Moves the pointer of the views to its position at the time of a key press, before the key is handled. On X11 Qt
/// drops a movement if a later one is in the queue, even across a key press; when frames take long, marks made by keys
/// would then lie at an older position. X11 reports the position with each key press. Other platforms deliver all
/// movements.
class PointerAtKeys : public QObject, public QAbstractNativeEventFilter {
 public:
  explicit PointerAtKeys(QObject* parent);
  ~PointerAtKeys() override;

  bool nativeEventFilter(const QByteArray& type, void* message, qintptr* result) override;

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  struct Press {
    quint64 time_ms;
    QPoint pixel;  ///< in the window with the focus, device pixels
  };
  void move_pointer(QWindow& window, const QInputEvent& key);

  std::deque<Press> presses_;  ///< latest last
  QWindow* window_ = nullptr;  ///< window of the last movement that was delivered; compared only
  QPointF at_;                 ///< position in that window, logical pixels
};

}  // namespace simplexseg
