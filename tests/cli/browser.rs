//! A browser with a hand: Chromium, driven by messages of its DevTools protocol through a pipe.

use crate::export::chromium;
use crate::sandbox::{Sandbox, TIMEOUT};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Width and height of the screen of a small phone [CSS pixels].
const PHONE: [u32; 2] = [375, 667];

/// A tab of a browser.
pub struct Browser {
    process: Child,
    to: ChildStdin,
    from: Receiver<Value>,
    session: Option<String>,
    number: u64,
    /// Messages on the console, warnings and exceptions.
    pub console: Vec<Value>,
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Browser {
    /// Starts Chromium with a small screen and a finger instead of a mouse.
    pub fn on_a_phone(sandbox: &Sandbox) -> Self {
        let mut browser = Self::with(sandbox, &[]);
        let [width, height] = PHONE;
        let screen = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": true });
        browser.call("Emulation.setDeviceMetricsOverride", screen);
        browser.call("Emulation.setTouchEmulationEnabled", json!({ "enabled": true, "maxTouchPoints": 2 }));
        browser
    }

    /// Starts Chromium with an empty page and further `arguments`.
    pub fn with(sandbox: &Sandbox, arguments: &[&str]) -> Self {
        let mut chromium = chromium(sandbox);
        chromium.args(arguments);
        let mut command = Command::new("sh");
        // The browser listens to descriptor 3 and answers on 4. Messages end with a zero.
        command.args(["-c", "exec \"$@\" 3<&0 4>&1 >/dev/null", "sh"]);
        command.arg(chromium.get_program()).args(chromium.get_args()).args(["--remote-debugging-pipe"]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut process = command.spawn().unwrap();
        let (to, out) = (process.stdin.take().unwrap(), process.stdout.take().unwrap());
        let (sender, from) = channel();
        std::thread::spawn(move || {
            for message in BufReader::new(out).split(0).map_while(Result::ok) {
                let _ = sender.send(serde_json::from_slice(&message).unwrap());
            }
        });
        let mut browser = Self { process, to, from, session: None, number: 0, console: Vec::new() };
        let made = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attached =
            browser.call("Target.attachToTarget", json!({ "targetId": made["targetId"], "flatten": true }));
        browser.session = Some(attached["sessionId"].as_str().unwrap().to_owned());
        for domain in ["Page.enable", "Runtime.enable", "Log.enable"] {
            browser.call(domain, json!({}));
        }
        browser
    }

    /// Gives the page a screen of this width and height [CSS pixels], with `scale` pixels for each.
    pub fn resize(&mut self, [width, height]: [u32; 2], scale: u32) {
        let screen = json!({ "width": width, "height": height, "deviceScaleFactor": scale, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", screen);
    }

    /// Sends a command and returns its result.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.number += 1;
        let mut message = json!({ "id": self.number, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        let mut bytes = message.to_string().into_bytes();
        bytes.push(0);
        self.to.write_all(&bytes).unwrap();
        loop {
            let answer = self.from.recv_timeout(TIMEOUT).unwrap_or_else(|e| panic!("{method}: {e}"));
            if answer["id"] == self.number {
                assert!(answer.get("error").is_none(), "{method}: {answer}");
                return answer["result"].clone();
            }
            let event = answer["method"].as_str().unwrap_or_default();
            // A driver tells of slow reads of pictures, which are the tests' own, where the machine is busy.
            let is_of_driver = answer["params"]["entry"]["text"]
                .as_str()
                .is_some_and(|text| text.contains("GL Driver Message (OpenGL, Performance"));
            let tells = ["Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded"];
            if tells.contains(&event) && !is_of_driver {
                self.console.push(answer);
            }
        }
    }

    /// Opens a page of the sandbox.
    pub fn load(&mut self, sandbox: &Sandbox, name: &str) {
        self.call("Page.navigate", json!({ "url": format!("file://{}", sandbox.path(name).display()) }));
        self.wait("document.readyState === 'complete' && location.protocol === 'file:'");
    }

    /// Opens a page of an export and waits until it has drawn or said why it cannot.
    pub fn open(&mut self, sandbox: &Sandbox, name: &str) {
        self.load(sandbox, name);
        self.wait_for_picture();
    }

    /// Waits until the page has drawn all that was asked for in full size, or said why it cannot.
    pub fn wait_for_picture(&mut self) {
        self.wait("['drawn', 'failed'].includes(document.documentElement.dataset.state)");
    }

    /// Waits until an expression of JavaScript is true.
    fn wait(&mut self, expression: &str) {
        let begin = Instant::now();
        while self.value(expression) != true {
            assert!(begin.elapsed() < TIMEOUT, "not {expression}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Returns the value of an expression of JavaScript.
    pub fn value(&mut self, expression: &str) -> Value {
        let asked = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let answer = self.call("Runtime.evaluate", asked);
        assert!(answer.get("exceptionDetails").is_none(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }

    /// Returns the numbers of an expression whose value is an array.
    pub fn numbers<const N: usize>(&mut self, expression: &str) -> [f64; N] {
        self.list(expression).try_into().unwrap()
    }

    /// Returns as many numbers as an expression has.
    pub fn list(&mut self, expression: &str) -> Vec<f64> {
        let value = self.value(expression);
        value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    }

    /// Returns what the page of an export measured as its deviation from the table.
    pub fn deviation(&mut self) -> f64 {
        self.value("Number(document.documentElement.dataset.deviation)").as_f64().unwrap()
    }

    /// Returns the linear radiance of the shape of the page of an export, rows from the bottom, with `state` changed as this object says.
    pub fn radiance(&mut self, side: usize, state: &str) -> Vec<[f32; 4]> {
        let numbers = self.list(&format!("Object.assign(state, {state}); [...radiance({side}, {side})]"));
        let numbers: Vec<f32> = numbers.into_iter().map(|x| x as f32).collect();
        numbers.as_chunks().0.to_vec()
    }

    /// Returns the middle of an element on the screen.
    pub fn middle(&mut self, selector: &str) -> [f64; 2] {
        self.numbers(&format!(
            "(({{ x, y, width, height }}) => [x + width / 2, y + height / 2])(document.querySelector('{selector}').getBoundingClientRect())"
        ))
    }

    /// Moves fingers from places by displacements, in steps as a hand makes them.
    pub fn drag(&mut self, fingers: &[([f64; 2], [f64; 2])]) {
        const STEPS: u32 = 6;
        for step in 0..=STEPS {
            let share = f64::from(step) / f64::from(STEPS);
            let points: Vec<Value> = fingers
                .iter()
                .enumerate()
                .map(|(id, (from, by))| json!({ "id": id, "x": from[0] + share * by[0], "y": from[1] + share * by[1] }))
                .collect();
            let kind = if step == 0 { "touchStart" } else { "touchMove" };
            self.call("Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points }));
        }
        self.call("Input.dispatchTouchEvent", json!({ "type": "touchEnd", "touchPoints": [] }));
    }
}
