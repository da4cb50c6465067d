// SPDX-License-Identifier: Apache-2.0
#include "gui/window/startup.h"

#include <QApplication>
#include <QCommandLineParser>
#include <QLocale>
#include <QOffscreenSurface>
#include <QOpenGLContext>
#include <QSurfaceFormat>
#include <QTimer>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include "core/freed_memory.h"
#include "gpu/backend.h"
#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/window/autosave.h"
#include "gui/window/file_actions.h"
#include "gui/window/key_settings.h"
#include "gui/window/main_window.h"
#include "gui/window/measurement.h"
#include "gui/window/theme_settings.h"
#include "gui/window/window_memory.h"
#include "gui/workbench/workbench.h"
#include "io/platform/output_checks.h"
#include "io/scene/scene_io.h"

namespace simplexseg {
namespace {

constexpr int kDone = 0, kFailed = 1, kBadInput = 2;

struct Options {
  QString input, screenshot, log;
  std::optional<int> steps;
  std::optional<double> measure_s;
  QSize size;
  bool size_given = false;
  std::optional<theme::Choice> theme;
  Backend backend = Backend::Auto;
};

int report_error(int status, const QString& text) {
  std::fprintf(stderr, "simplexseg: %s\n", qUtf8Printable(text.simplified()));
  return status;
}

int fail(const std::exception& error, int status) { return report_error(status, QString::fromUtf8(error.what())); }

// Without a display, Qt would abort with a core dump; this handler prints one line and exits with a status instead.
void report_fatal(QtMsgType type, const QMessageLogContext&, const QString& text) {
  static QString cause;
  if (type == QtWarningMsg && text.contains("could not connect to display")) {
    cause = qEnvironmentVariableIsEmpty("DISPLAY") ? "there is no display" : text;
  }
  if (type == QtFatalMsg) {
    std::_Exit(report_error(kFailed, "cannot open a window: " + (cause.isEmpty() ? text.section('\n', 0, 0) : cause) +
                                         "; run it on a display, or use simplexseg-cli, which needs none"));
  }
  if (type == QtCriticalMsg) std::fprintf(stderr, "simplexseg: %s\n", qUtf8Printable(text.simplified()));
}

/// Parses the arguments into `options`. Returns an exit status if the program ends here, else none.
std::optional<int> parse(const QStringList& arguments, Options& options) {
  QCommandLineParser parser;
  parser.setApplicationDescription("SimplexSeg: segments medical volumes with live deformable simplex meshes.");
  parser.addPositionalArgument("INPUT", "a scene (.json), a volume, or a folder with a DICOM series", "[INPUT]");
  const QCommandLineOption help({"h", "help"}, "show this help"), version({"v", "version"}, "show the version");
  const QCommandLineOption backend("backend", "compute backend: auto, cpu or cuda", "NAME", "auto");
  const QCommandLineOption screenshot("screenshot", "run the scene, save a picture of the window as PNG, and exit",
                                      "FILE");
  const QCommandLineOption steps("steps", "with --screenshot: number of steps; default: the number in the scene", "N");
  const QCommandLineOption size("size", "size of the window, such as 1280x800", "WxH", "1280x800");
  const QCommandLineOption measure("measure",
                                   "run the scene, drag a point, print frame rate and latency as JSON, and exit; with "
                                   "--screenshot also save a picture",
                                   "SECONDS");
  const QCommandLineOption log("log", "write the log of all actions on exit", "FILE");
  const QCommandLineOption theme_name("theme", "theme of this run: dark or light", "NAME");
  parser.addOptions({help, version, backend, screenshot, steps, size, measure, log, theme_name});
  if (!parser.parse(arguments)) return report_error(kBadInput, parser.errorText() + "; see --help");
  if (parser.isSet(help)) {
    std::fputs(qUtf8Printable(parser.helpText().replace("<executable_name>", "simplexseg")), stdout);
    return kDone;
  }
  if (parser.isSet(version)) {
    std::puts("simplexseg " SIMPLEXSEG_VERSION);
    return kDone;
  }
  const QStringList inputs = parser.positionalArguments();
  if (inputs.size() > 1)
    return report_error(kBadInput, "more than one input, such as " + inputs[1] + "; give one scene, volume or folder");
  if (!inputs.isEmpty()) options.input = inputs.front();
  if (!options.input.isEmpty() && !path_exists(options.input)) {
    return report_error(kBadInput, options.input + ": file not found; check the path");
  }
  if (parser.isSet(theme_name)) {
    const QString name = parser.value(theme_name);
    if (name != "dark" && name != "light")
      return report_error(kBadInput, "--theme " + name + ": unknown theme; give dark or light");
    options.theme = name == "light" ? theme::Choice::Light : theme::Choice::Dark;
  }
  const QString name = parser.value(backend);
  if (name != "auto" && name != "cpu" && name != "cuda") {
    return report_error(kBadInput, "--backend " + name + ": unknown backend; give auto, cpu or cuda");
  }
  if (name == "cpu") options.backend = Backend::Cpu;
  if (name == "cuda") options.backend = Backend::Cuda;
  options.size_given = parser.isSet(size);
  const QStringList sides = parser.value(size).split('x');
  if (sides.size() == 2) options.size = QSize(sides[0].toInt(), sides[1].toInt());
  if (options.size.width() < 640 || options.size.height() < 480 || options.size.width() > 16384 ||
      options.size.height() > 16384) {
    return report_error(
        kBadInput, "--size " + parser.value(size) + ": not a size of at least 640x480; give a size such as 1280x800");
  }
  options.screenshot = parser.value(screenshot);
  options.log = parser.value(log);
  if (parser.isSet(screenshot) && options.screenshot.isEmpty())
    return report_error(kBadInput, "--screenshot: no file name; give one");
  if (parser.isSet(log) && options.log.isEmpty()) return report_error(kBadInput, "--log: no file name; give one");
  try {
    OutputChecks outputs(std::vector<std::filesystem::path>{to_path(options.input)});
    for (const QString& output : {options.screenshot, options.log})
      if (!output.isEmpty()) outputs.require_file(to_path(output));
  } catch (const std::exception& error) {
    return fail(error, kBadInput);
  }
  if (parser.isSet(measure)) {
    bool good = false;
    options.measure_s = parser.value(measure).toDouble(&good);
    if (!good || !(*options.measure_s > 0 && *options.measure_s <= 3600)) {
      return report_error(kBadInput,
                          "--measure " + parser.value(measure) + ": not a number of seconds up to 3600; give e.g. 10");
    }
    if (options.input.isEmpty() || parser.isSet(steps))
      return report_error(kBadInput,
                          "--measure needs a scene and cannot be combined with --steps; give a scene and omit --steps");
  }
  if (parser.isSet(steps)) {
    bool good = false;
    options.steps = parser.value(steps).toInt(&good);
    if (!good || *options.steps < 0) {
      return report_error(kBadInput,
                          "--steps " + parser.value(steps) + ": not a number of steps; give a whole number, 0 or more");
    }
    if (options.screenshot.isEmpty())
      return report_error(kBadInput, "--steps needs --screenshot; add --screenshot FILE");
  }
  return std::nullopt;
}

/// Opens the input and shows the window. Returns an exit status on failure, else none.
std::optional<int> load(MainWindow& window, const Options& options) {
  window.set_unattended();
  try {
    const std::filesystem::path input = to_path(options.input);
    if (!options.input.isEmpty()) window.files().open_loaded(load_input(input), input);
  } catch (const std::exception& error) {
    return fail(error, kBadInput);
  }
  window.show();
  return std::nullopt;
}

int save_screenshot(QApplication& application, MainWindow& window, const Options& options) {
  // Layout and painting take a few rounds of the event loop.
  for (int round = 0; round < 10; ++round) application.processEvents(QEventLoop::AllEvents, 50);
  try {
    window.save_picture(options.screenshot);
  } catch (const std::exception& error) {
    return fail(error, kFailed);
  }
  return kDone;
}

int take_screenshot(QApplication& application, MainWindow& window, const Options& options) {
  if (const std::optional<int> status = load(window, options)) return *status;
  // A scene without a number of steps runs until it settles; the bound stops a scene that never settles.
  constexpr int kMostSteps = 5000;
  const int requested = options.steps.value_or(window.workbench().scene().steps);
  const bool until_settled = !options.steps && requested == 0;
  int left = until_settled ? kMostSteps : requested;
  while (left > 0 && !window.workbench().scene().meshes.empty()) {
    const Advance done = window.workbench().advance_steps(std::min(left, 20), until_settled);
    left -= done.steps;
    if (done.failure) return report_error(kFailed, QString::fromStdString(*done.failure));
    if (done.steps == 0 || (until_settled && done.at_rest)) break;
  }
  return save_screenshot(application, window, options);
}

int measure_window(QApplication& application, MainWindow& window, const Options& options) {
  if (const std::optional<int> status = load(window, options)) return *status;
  try {
    std::fputs(measure(window, *options.measure_s).constData(), stdout);
  } catch (const std::exception& error) {
    return fail(error, kBadInput);
  }
  return options.screenshot.isEmpty() ? kDone : save_screenshot(application, window, options);
}

int run_window(QApplication& application, MainWindow& window, const Options& options, const std::string& note) {
  WindowMemory memory(window);
  Autosave autosave(window.workbench(), window.files(), window.job(), window, Autosave::default_root());
  if (!options.size_given) memory.restore_geometry();
  fit_on_screen(window);
  window.show();
  if (!note.empty()) window.workbench().notify(Severity::Note, QString::fromStdString(note));
  if (!options.input.isEmpty()) QTimer::singleShot(0, &window, [&] { window.files().open(options.input); });
  QTimer::singleShot(0, &autosave, &Autosave::offer_recovery);
  return application.exec();
}

}  // namespace

void set_surface_format() {
  QSurfaceFormat format;
  format.setRenderableType(QSurfaceFormat::OpenGL);
  format.setVersion(4, 5);
  format.setProfile(QSurfaceFormat::CoreProfile);
  format.setDepthBufferSize(24);
  format.setStencilBufferSize(8);
  QSurfaceFormat::setDefaultFormat(format);
  // The views share their buffers.
  QCoreApplication::setAttribute(Qt::AA_ShareOpenGLContexts);
}

std::string why_no_opengl() {
  // Qt 6.4 creates contexts on these platforms, and then crashes when it composes a window.
  const QString platform = QGuiApplication::platformName();
  if (platform == "offscreen" || platform == "minimal")
    return "Qt's platform '" + platform.toStdString() + "' does not support it";
  QOffscreenSurface surface;
  surface.setFormat(QSurfaceFormat::defaultFormat());
  surface.create();
  QOpenGLContext context;
  context.setFormat(QSurfaceFormat::defaultFormat());
  if (!surface.isValid() || !context.create() || !context.makeCurrent(&surface))
    return "no OpenGL context can be created";
  const QSurfaceFormat got = context.format();
  if (got.version() < qMakePair(4, 5)) {
    return "the driver offers OpenGL " + std::to_string(got.majorVersion()) + "." + std::to_string(got.minorVersion());
  }
  return {};
}

int run_desktop(int argc, char** argv) {
  keep_freed_memory();
  QStringList arguments;
  for (int n = 0; n < argc; ++n) arguments << text(std::filesystem::path(argv[n]));
  Options options;
  if (const std::optional<int> status = parse(arguments, options)) return *status;

  qInstallMessageHandler(report_fatal);
  // Numbers have a decimal point everywhere, as in the command line; dates are shown as the system does.
  QLocale::setDefault(QLocale::c());
  set_surface_format();
  QApplication application(argc, argv);
  QApplication::setApplicationName("SimplexSeg");
  // Screenshots and measurements do not depend on the theme of the desktop.
  std::optional<ThemeSettings> theme_settings;
  const bool for_a_user = options.screenshot.isEmpty() && !options.measure_s;
  if (for_a_user)
    theme_settings.emplace(application, options.theme);
  else
    theme::apply(application, options.theme.value_or(theme::Choice::Dark) != theme::Choice::Light);
  if (const std::string why = why_no_opengl(); !why.empty()) {
    return report_error(kFailed,
                        "OpenGL 4.5 is needed for the window: " + QString::fromStdString(why) +
                            "; update the graphics driver or Mesa, or use simplexseg-cli, which works without it");
  }
  EngineChoice choice;
  try {
    choice = make_engine(options.backend);
  } catch (const std::exception& error) {
    return report_error(kFailed, QString::fromUtf8(error.what()));
  }
  MainWindow window(std::move(choice.engine), std::move(choice.make_fallback));
  window.workbench().set_field_solver(std::move(choice.fields));
  window.set_engine_maker([backend = options.backend] { return make_engine(backend).engine; });
  window.resize(options.size);
  if (theme_settings) {
    theme_settings->fill(*window.view_menu());
    QObject::connect(&*theme_settings, &ThemeSettings::message, &window,
                     [&window](const QString& text) { window.workbench().notify(Severity::Note, text); });
  }
  std::optional<KeySettings> key_settings;
  if (for_a_user) key_settings.emplace();
  // Later than the notes of the start, which would replace it.
  if (key_settings && !key_settings->fault().isEmpty())
    QTimer::singleShot(
        0, &window, [&window, fault = key_settings->fault()] { window.workbench().notify(Severity::Warning, fault); });
  int status = kDone;
  if (options.measure_s) {
    status = measure_window(application, window, options);
  } else if (!options.screenshot.isEmpty()) {
    status = take_screenshot(application, window, options);
  } else {
    status = run_window(application, window, options, choice.note);
  }
  if (status == kDone && !options.log.isEmpty()) {
    try {
      const Session& session = window.workbench().session();
      write_log(to_path(options.log), session.log(), session.steps_since_last_command());
    } catch (const std::exception& error) {
      return report_error(kFailed, QString::fromUtf8(error.what()));
    }
  }
  return status;
}

}  // namespace simplexseg
