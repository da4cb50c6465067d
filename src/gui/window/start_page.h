// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>

class QVBoxLayout;

namespace simplexseg {

class ActionTable;

/// Page that covers the views while no volume is open, and offers to open one.
class StartPage : public QWidget {
  Q_OBJECT
 public:
  StartPage(ActionTable& actions, QWidget* over);
  /// Lists recently opened files, latest first, at most five; omits missing files.
  void show_recent(const QStringList& paths);

 signals:
  void open_requested(const QString& path);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  void add_path(const QString& title, const QString& path);

  QWidget* recent_ = nullptr;
  QVBoxLayout* recent_column_ = nullptr;
};

}  // namespace simplexseg
