// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/repeated_warning.h"

namespace simplexseg {

RepeatedWarning::RepeatedWarning(int interval_ms, QObject* parent) : QObject(parent) {
  pause_.setSingleShot(true);
  pause_.setInterval(interval_ms);
  connect(&pause_, &QTimer::timeout, this, [this] {
    if (untold_ > 0) tell_now();
  });
}

void RepeatedWarning::add(const std::vector<std::string>& lines) {
  if (lines.empty()) return;
  latest_ = QString::fromStdString(lines.back());
  untold_ += static_cast<int>(lines.size());
  if (!pause_.isActive()) tell_now();
}

void RepeatedWarning::forget() {
  pause_.stop();
  untold_ = 0;
}

void RepeatedWarning::tell_now() {
  const QString text = untold_ == 1 ? latest_ : tr("%1 (and %2 more)").arg(latest_).arg(untold_ - 1);
  untold_ = 0;
  pause_.start();
  emit tell(text);
}

}  // namespace simplexseg
