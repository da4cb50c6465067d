// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/repeated_warning.h"

namespace simplexseg {

RepeatedWarning::RepeatedWarning(int interval_ms, QObject* parent) : QObject(parent) {
  pause_.setSingleShot(true);
  pause_.setInterval(interval_ms);
  connect(&pause_, &QTimer::timeout, this, [this] {
    if (pending_ > 0) send();
  });
}

void RepeatedWarning::add(const std::vector<std::string>& lines) {
  if (lines.empty()) return;
  latest_ = QString::fromStdString(lines.back());
  pending_ += static_cast<int>(lines.size());
  if (!pause_.isActive()) send();
}

void RepeatedWarning::clear() {
  pause_.stop();
  pending_ = 0;
}

void RepeatedWarning::send() {
  const QString text = pending_ == 1 ? latest_ : tr("%1 (and %2 more)").arg(latest_).arg(pending_ - 1);
  pending_ = 0;
  pause_.start();
  emit message(text);
}

}  // namespace simplexseg
