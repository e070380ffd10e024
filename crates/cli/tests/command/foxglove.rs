//! `live --foxglove`, in programs that have it and in others.

use crate::workbench::Workbench;

#[cfg(not(feature = "foxglove"))]
#[test]
fn a_program_without_foxglove_says_so() {
    let bench = Workbench::new();
    bench.press(3);
    let ended = bench.run("live press --no-page --foxglove");
    assert_eq!(ended.code, Some(2), "{ended:?}");
    assert!(ended.errors.contains("built without Foxglove") && ended.errors.contains("--features"), "{ended:?}");
}

#[cfg(feature = "foxglove")]
mod built_in {
    use std::io::{BufRead, BufReader, Read, Write};
    use std::net::{TcpListener, TcpStream};
    use std::process::{Child, Stdio};
    use std::time::Duration;

    use super::*;

    /// Longer than a development build needs to solve and track a press.
    const WAIT: Duration = Duration::from_mins(2);

    /// Ends the command when a test fails, too.
    struct Running(Child);

    impl Drop for Running {
        fn drop(&mut self) {
            let _ = self.0.kill();
            let _ = self.0.wait();
        }
    }

    #[test]
    fn foxglove_is_offered_the_topics_of_a_sensor() {
        let bench = Workbench::new();
        let mut command = bench.command("live sim:board?loop&draft --no-page --foxglove=0");
        let mut running = Running(command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap());
        let mut errors = BufReader::new(running.0.stderr.take().unwrap());
        let mut line = String::new();
        while !line.contains("Foxglove: open the connection ws://") {
            line.clear();
            assert!(errors.read_line(&mut line).unwrap() > 0, "the command ended without a server");
        }
        let host = line.trim_end().rsplit("ws://").next().unwrap();
        let mut stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(WAIT)).unwrap();
        write!(
            stream,
            "GET / HTTP/1.1\r\nHost: {host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
             Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"
        )
        .unwrap();
        // The server's texts are not masked, so they can be read as they are.
        let (mut answer, mut part) = (String::new(), [0; 4096]);
        while !answer.contains("\"/board/reading\"") {
            let count = stream.read(&mut part).unwrap();
            assert!(count > 0, "the server closed the connection: {answer}");
            answer.push_str(&String::from_utf8_lossy(&part[..count]));
        }
        assert!(answer.starts_with("HTTP/1.1 101") && answer.contains("\"serverInfo\""), "{answer}");
    }

    #[test]
    fn a_port_for_foxglove_that_is_taken_is_refused() {
        let bench = Workbench::new();
        let other = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = other.local_addr().unwrap().port();
        bench
            // Before the source is opened: there is none of this name.
            .run(&format!("live press --no-page --foxglove={port}"))
            .expect_failure(&format!("at port {port}: it is taken"), "--foxglove=8766");
        let ended = bench.run("live press --no-page --foxglove=70000");
        assert_eq!(ended.code, Some(2), "{ended:?}");
        assert!(ended.errors.contains("a port is a whole number"), "{ended:?}");
    }
}
