use std::io::Write;
use std::net::SocketAddr;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use super::*;
use crate::watch::document::Document;

async fn started(source: Source) -> SocketAddr {
    let listener = listen(0).await.unwrap();
    let address = listener.local_addr().unwrap();
    tokio::spawn(serve(listener, source));
    address
}

async fn ask(address: SocketAddr, path: &str) -> TcpStream {
    let mut stream = TcpStream::connect(address).await.unwrap();
    let mut request = Vec::new();
    write!(request, "GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").unwrap();
    stream.write_all(&request).await.unwrap();
    stream
}

/// Status line, headers and body.
async fn answer(address: SocketAddr, path: &str) -> String {
    let mut text = String::new();
    ask(address, path).await.read_to_string(&mut text).await.unwrap();
    text
}

/// Reads until `wanted` was read.
async fn read_until(stream: &mut TcpStream, wanted: &str) -> String {
    let (mut text, mut buffer) = (String::new(), [0; 4096]);
    while !text.contains(wanted) {
        let reading = tokio::time::timeout(Duration::from_secs(20), stream.read(&mut buffer)).await;
        let length = reading.unwrap_or_else(|_| panic!("no `{wanted}` in: {text}")).unwrap();
        assert!(length > 0, "ended before `{wanted}`: {text}");
        text += std::str::from_utf8(&buffer[..length]).unwrap();
    }
    text
}

fn document(topic: &str, time_s: f64) -> Document {
    let body = format!("{{\"time_s\":{time_s},\"p_world\":[1,2,3]}}");
    Document::parse(topic, body.as_bytes()).unwrap()
}

#[tokio::test]
async fn a_port_that_is_taken_is_said_with_the_way_out() {
    let first = listen(0).await.unwrap();
    let port = first.local_addr().unwrap().port();
    let error = listen(port).await.unwrap_err();
    assert!(error.is_mistake());
    assert_eq!(
        error.to_string(),
        format!("port {port} of 127.0.0.1 is taken: expected a free one with --port")
    );
}

#[tokio::test]
async fn the_page_needs_nothing_from_outside() {
    let address = started(Source::Live(Arc::default())).await;
    let page = answer(address, "/").await;
    assert!(page.starts_with("HTTP/1.1 200"), "{page}");
    let policy = page.lines().find(|l| l.starts_with("content-security-policy")).unwrap();
    assert!(policy.contains("default-src 'none'") && !policy.contains("unsafe"), "{policy}");
    assert!(!page.contains("http://") && !page.contains("https://"), "no outside addresses");
    assert!(answer(address, "/elsewhere").await.starts_with("HTTP/1.1 404"));
}

#[tokio::test]
async fn a_page_hears_batches_and_comes_back_to_the_newest_state() {
    let hub = Arc::new(Hub::default());
    let address = started(Source::Live(hub.clone())).await;
    let mut page = ask(address, "/events?agent=1").await;
    let greeting = read_until(&mut page, "\"documents\":{}").await;
    assert!(greeting.contains("text/event-stream"), "{greeting}");
    hub.begin("3");
    hub.publish([document("view/0/oem", 0.5), document("view/1/oem", 0.5)]);
    let text = read_until(&mut page, "oem").await;
    assert!(text.contains("event: batch") && text.contains("\"run\":\"3\""), "{text}");
    assert!(text.contains("view/1/oem") && !text.contains("view/0/oem"), "{text}");
    drop(page);
    hub.publish([document("view/1/pose", 1.0)]);
    let mut page = ask(address, "/events?agent=0").await;
    let text = read_until(&mut page, "view/1/pose").await;
    assert!(text.contains("view/0/oem"), "{text}");
    assert!(answer(address, "/series").await.contains("{\"1\":[[1,1.00,2.00]]}"));
    assert!(answer(address, "/at?time_s=1").await.starts_with("HTTP/1.1 404"));
}

#[tokio::test]
async fn a_fast_fleet_makes_no_more_than_ten_batches_a_second() {
    let hub = Arc::new(Hub::default());
    hub.begin("1");
    let address = started(Source::Live(hub.clone())).await;
    let mut page = ask(address, "/events").await;
    for step in 0..100 {
        hub.publish([document("view/0/pose", f64::from(step))]);
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    let text = read_until(&mut page, "\"time_s\":99,").await;
    let batches = text.matches("event: batch").count();
    // Half a second or, on a computer with much to do, more.
    assert!((2..50).contains(&batches), "{batches}");
}

#[tokio::test]
async fn a_recording_is_served_by_time() {
    let steps = (0..5).map(|step| document("view/0/pose", f64::from(step)));
    let address = started(Source::Recorded(Arc::new(Recording::new(steps.collect())))).await;
    assert!(answer(address, "/recording").await.contains("\"end_s\":4.0"));
    let text = answer(address, "/at?time_s=2.5&agent=0&town=false").await;
    assert!(text.contains("{\"view/0/pose\":{\"time_s\":2,"), "{text}");
    for bad in ["/at", "/at?time_s=soon", "/at?time_s=1&agent=-1"] {
        assert!(answer(address, bad).await.starts_with("HTTP/1.1 400"), "{bad}");
    }
    for odd in ["/at?time_s=nan", "/at?time_s=-inf"] {
        assert!(answer(address, odd).await.ends_with("{}"), "{odd}");
    }
    assert!(answer(address, "/events").await.starts_with("HTTP/1.1 404"));
}
