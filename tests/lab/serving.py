"""A server of files on this machine: plain HTTP with a page of links, and as much of S3 as reading
takes (path style, no signatures checked).
"""

import contextlib
import hashlib
import threading
from email.utils import formatdate
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import parse_qs, unquote, urlsplit
from xml.sax.saxutils import escape


class Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *_):
        pass

    def answer(self, status, body, **headers):
        self.send_response(status)
        for name, value in {"Content-Length": len(body), **headers}.items():
            self.send_header(name.replace("_", "-"), str(value))
        self.end_headers()
        if self.command == "GET":
            self.wfile.write(body)

    def do_GET(self):
        asked = urlsplit(self.path)
        query, path = (
            parse_qs(asked.query),
            Path(self.server.folder, unquote(asked.path).strip("/")),
        )
        if "list-type" in query:
            return self.answer(
                200,
                self.listing(path, query.get("prefix", [""])[0]),
                Content_Type="application/xml",
            )
        if path.is_dir():
            links = "".join(
                f'<a href="{escape(one.name)}">{escape(one.name)}</a>\n'
                for one in sorted(path.iterdir())
            )
            return self.answer(200, f"<html>{links}</html>".encode(), Content_Type="text/html")
        if not path.is_file():
            return self.answer(404, b"")
        body = path.read_bytes()
        tells = {
            "ETag": self.tag(body),
            "Last_Modified": formatdate(path.stat().st_mtime, usegmt=True),
            "Accept_Ranges": "bytes",
        }
        with self.server.lock:
            self.server.fetched += [path.name] if self.command == "GET" else []
        if "Range" in self.headers:
            first, last = self.headers["Range"].removeprefix("bytes=").split("-")
            part = body[int(first) : int(last) + 1 if last else None]
            return self.answer(
                206,
                part,
                Content_Range=f"bytes {first}-{int(first) + len(part) - 1}/{len(body)}",
                **tells,
            )
        return self.answer(200, body, **tells)

    do_HEAD = do_GET

    @staticmethod
    def tag(body):
        return f'"{hashlib.md5(body).hexdigest()}"'

    def listing(self, bucket, prefix):
        files = [path for path in sorted(bucket.iterdir()) if path.name.startswith(prefix)]
        rows = "".join(
            f"<Contents><Key>{escape(path.name)}</Key><LastModified>2026-01-05T00:00:00.000Z</LastModified><ETag>{escape(self.tag(path.read_bytes()))}</ETag>"
            f"<Size>{path.stat().st_size}</Size><StorageClass>STANDARD</StorageClass></Contents>"
            for path in files
        )
        return (
            '<?xml version="1.0"?>'
            '<ListBucketResult xmlns="http://s3.amazonaws.com/doc/2006-03-01/">'
            f"<Name>{bucket.name}</Name><Prefix>{escape(prefix)}</Prefix>"
            f"<KeyCount>{len(files)}</KeyCount><MaxKeys>1000</MaxKeys><IsTruncated>false</IsTruncated>{rows}</ListBucketResult>"
        ).encode()


@contextlib.contextmanager
def serving(folder):
    """Serves the files below a folder; yields the server: `port`, and `fetched`, the names of files
    that were got.
    """
    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.folder, server.fetched, server.lock, server.port = (
        folder,
        [],
        threading.Lock(),
        server.server_address[1],
    )
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield server
    finally:
        server.shutdown()
        server.server_close()
