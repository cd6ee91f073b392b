//! A headless browser, and a page in it.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::ffi::OsStr;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use headless_chrome::protocol::cdp::types::Event;
use headless_chrome::protocol::cdp::{Emulation, Input, Page};
use headless_chrome::{Browser, LaunchOptions, Tab};
use serde_json::Value;

/// Timeout: a browser on a busy machine is slow.
const PATIENCE: Duration = Duration::from_secs(60);
/// The browser's executable, as installed by `cargo xtask setup`.
const PROGRAMS: [&str; 3] = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
/// Without these options the browser contacts its vendor's servers.
const QUIET: [&str; 4] = ["--disable-quic", "--disable-component-update", "--disable-sync", "--no-first-run"];

/// An open page.
pub struct Sheet {
    tab: Arc<Tab>,
    /// Errors and warnings from the page's scripts, including exceptions.
    pub complaints: Arc<Mutex<Vec<String>>>,
    _browser: Browser,
}

/// A mouse action.
#[derive(Clone, Copy, Debug)]
pub enum Mouse {
    Move,
    Press,
    Release,
}

impl Sheet {
    /// Opens a file in a window of that size.
    pub fn open(file: &Path, width: u32, height: u32) -> Self {
        let program = PROGRAMS.iter().find(|program| Path::new(program).exists());
        let program = program.unwrap_or_else(|| panic!("no Chromium: `cargo xtask setup` installs it"));
        let options = LaunchOptions {
            // The browser's sandbox does not work for root, and the only page is ours.
            sandbox: false,
            window_size: Some((width, height)),
            path: Some(program.into()),
            args: QUIET.map(OsStr::new).into(),
            idle_browser_timeout: PATIENCE,
            ..LaunchOptions::default()
        };
        let browser = Browser::new(options).unwrap();
        let tab = browser.new_tab().unwrap();
        tab.set_default_timeout(PATIENCE);
        let complaints = Arc::new(Mutex::new(Vec::new()));
        let said = Arc::clone(&complaints);
        tab.add_event_listener(Arc::new(move |event: &Event| match event {
            Event::RuntimeConsoleAPICalled(call) => {
                said.lock().unwrap().push(format!("{:?}", call.params.args));
            }
            Event::RuntimeExceptionThrown(thrown) => {
                said.lock().unwrap().push(format!("{:?}", thrown.params.exception_details));
            }
            Event::LogEntryAdded(entry) => said.lock().unwrap().push(entry.params.entry.text.clone()),
            _ => {}
        }))
        .unwrap();
        tab.enable_runtime().unwrap();
        tab.enable_log().unwrap();
        let sheet = Self { tab, complaints, _browser: browser };
        sheet.resize(width, height);
        sheet.tab.navigate_to(&format!("file://{}", file.display())).unwrap();
        sheet.wait("document.readyState === 'complete' && typeof pylonCharts === 'object'");
        sheet
    }

    /// Value of an expression in the page, by way of JSON; null where it has none.
    pub fn value(&self, expression: &str) -> Value {
        let expression = format!("JSON.stringify({expression})");
        // While one page replaces another, there is nothing to evaluate.
        match self.tab.evaluate(&expression, false).ok().and_then(|object| object.value) {
            Some(Value::String(json)) => serde_json::from_str(&json).unwrap(),
            _ => Value::Null,
        }
    }

    /// Value of a numeric expression in the page.
    pub fn number(&self, expression: &str) -> f64 {
        let value = self.value(expression);
        value.as_f64().unwrap_or_else(|| panic!("{expression} is {value}"))
    }

    /// Runs statements in the page.
    pub fn run(&self, statements: &str) {
        self.tab.evaluate(&format!("{{ {statements}; null }}"), false).unwrap();
    }

    /// Waits until an expression is true.
    pub fn wait(&self, condition: &str) {
        let start = Instant::now();
        while self.value(&format!("!!({condition})")) != Value::Bool(true) {
            assert!(start.elapsed() < PATIENCE, "never true: {condition}");
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Sets the window's size, CSS pixels.
    pub fn resize(&self, width: u32, height: u32) {
        self.tab
            .call_method(Emulation::SetDeviceMetricsOverride {
                width,
                height,
                device_scale_factor: 1.0,
                mobile: false,
                scale: None,
                screen_width: None,
                screen_height: None,
                position_x: None,
                position_y: None,
                dont_set_visible_size: None,
                screen_orientation: None,
                viewport: None,
                display_feature: None,
                device_posture: None,
            })
            .unwrap();
    }

    /// Sets the system's preferred colour scheme: `light` or `dark`.
    pub fn prefer(&self, scheme: &str) {
        let feature = Emulation::MediaFeature { name: "prefers-color-scheme".into(), value: scheme.into() };
        self.tab
            .call_method(Emulation::SetEmulatedMedia { media: None, features: Some(vec![feature]) })
            .unwrap();
    }

    /// Performs a mouse action at a place of the window; `clicks` marks the second press of a double click.
    pub fn mouse(&self, what: Mouse, (x, y): (f64, f64), clicks: u32) {
        let (kind, is_down) = match what {
            Mouse::Move => (Input::DispatchMouseEventTypeOption::MouseMoved, false),
            Mouse::Press => (Input::DispatchMouseEventTypeOption::MousePressed, true),
            Mouse::Release => (Input::DispatchMouseEventTypeOption::MouseReleased, true),
        };
        self.tab
            .call_method(Input::DispatchMouseEvent {
                Type: kind,
                x,
                y,
                button: (is_down || clicks > 0).then_some(Input::MouseButton::Left),
                buttons: (clicks > 0).then_some(u32::from(!matches!(what, Mouse::Release))),
                click_count: is_down.then_some(clicks),
                modifiers: None,
                timestamp: None,
                force: None,
                tangential_pressure: None,
                tilt_x: None,
                tilt_y: None,
                twist: None,
                delta_x: None,
                delta_y: None,
                pointer_Type: None,
            })
            .unwrap();
    }

    /// Presses a key.
    pub fn key(&self, key: &str) {
        self.tab.press_key(key).unwrap();
    }

    /// A picture of the window, as PNG.
    pub fn picture(&self) -> Vec<u8> {
        self.tab.capture_screenshot(Page::CaptureScreenshotFormatOption::Png, None, None, true).unwrap()
    }
}
