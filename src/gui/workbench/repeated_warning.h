// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QString>
#include <QTimer>
#include <string>
#include <vector>

namespace simplexseg {

/// Merges lines that may come with every frame into at most one message per interval: the latest line, and the number
/// of the other lines.
class RepeatedWarning : public QObject {
  Q_OBJECT
 public:
  explicit RepeatedWarning(int interval_ms = 3000, QObject* parent = nullptr);
  void add(const std::vector<std::string>& lines);
  /// Discards pending lines; the next line becomes a message at once.
  void clear();

 signals:
  void message(const QString& text);

 private:
  void send();

  QTimer pause_;
  QString latest_;
  int pending_ = 0;
};

}  // namespace simplexseg
