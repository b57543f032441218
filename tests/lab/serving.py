"""A server of files on this machine: plain HTTP with a page of links, and as much of S3 as reading
takes (path style, no signatures checked).
"""

import contextlib
import functools
import hashlib
import threading
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

OBJECT = (
    "<Contents><Key>{}</Key><LastModified>2026-01-05T00:00:00.000Z</LastModified>"
    "<ETag>&quot;{}&quot;</ETag><Size>{}</Size><StorageClass>STANDARD</StorageClass></Contents>"
)
LISTING = (
    '<?xml version="1.0"?><ListBucketResult xmlns="http://s3.amazonaws.com/doc/2006-03-01/">'
    "<Name>{}</Name><Prefix>{}</Prefix><KeyCount>{}</KeyCount><MaxKeys>1000</MaxKeys>"
    "<IsTruncated>false</IsTruncated>{}</ListBucketResult>"
)


def digest(path):
    return hashlib.md5(path.read_bytes()).hexdigest()


class Handler(SimpleHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *_):
        pass

    def end_headers(self):
        if (path := Path(self.translate_path(self.path))).is_file():
            self.send_header("ETag", f'"{digest(path)}"')
        super().end_headers()

    def do_GET(self):
        query, path = parse_qs(urlsplit(self.path).query), Path(self.translate_path(self.path))
        if "list-type" in query:
            return self.listed(path, query.get("prefix", [""])[0])
        with self.server.lock:
            self.server.fetched.append(path.name)
        return super().do_GET()

    def listed(self, bucket, prefix):
        files = [path for path in sorted(bucket.iterdir()) if path.name.startswith(prefix)]
        rows = [OBJECT.format(one.name, digest(one), one.stat().st_size) for one in files]
        body = LISTING.format(bucket.name, prefix, len(rows), "".join(rows)).encode()
        self.send_response(200)
        self.send_header("Content-Type", "application/xml")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)


@contextlib.contextmanager
def serving(folder):
    """Serves the files below a folder; yields the server: `server_port`, and `fetched`, the names
    of files that were got.
    """
    handler = functools.partial(Handler, directory=folder)
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        server.fetched, server.lock = [], threading.Lock()
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server
        server.shutdown()
