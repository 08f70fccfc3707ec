"""Datasets in object storage, against moto's S3 server: `s3.py SATSEED RECIPE FOLDER`.

Two writers on one shard, a writer killed in mid-upload, a server that answers 500 and 503 for a while or for good, wrong
keys, a changed object: nothing lost, nothing half, clear sentences. With `--conformance COMMAND...` the store's own
conformance suite runs against the server too.
"""

import http.client
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import boto3
from moto import settings
from moto.server import ThreadedMotoServer

SATSEED, RECIPE, FOLDER = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), Path(sys.argv[3])
CONFORMANCE = sys.argv[sys.argv.index("--conformance") + 1 :] if "--conformance" in sys.argv else []
BUCKET = "datasets"
checks = 0


def check(truth, what):
    global checks
    checks += 1
    if not truth:
        sys.exit(f"s3.py: {what}")


class Proxy(BaseHTTPRequestHandler):
    """Stands before the server and fails as servers do."""

    protocol_version = "HTTP/1.1"
    target = None
    lock = threading.Lock()
    failures = []  # statuses of the next answers
    always = None  # the status of all answers
    breaks = 0  # how many puts lose their connection after they were done
    hold = None  # the end of a key whose put is held when half of it has come
    held = threading.Event()
    seen = 0

    def log_message(self, *_):
        pass

    def answer(self):
        cls = Proxy
        length = int(self.headers.get("Content-Length") or 0)
        with cls.lock:
            cls.seen += 1
            status = cls.always or (cls.failures.pop(0) if cls.failures else None)
        if cls.hold and self.command == "PUT" and self.path.split("?")[0].endswith(cls.hold):
            self.rfile.read(length // 2)
            cls.held.set()
            time.sleep(30)
            return
        body = self.rfile.read(length)
        if status:
            return self.reply(status, {}, b"<Error><Code>SlowDown</Code><Message>Please wait</Message></Error>")
        connection = http.client.HTTPConnection(*cls.target)
        connection.request(self.command, self.path, body, dict(self.headers))
        answer = connection.getresponse()
        content = answer.read()
        with cls.lock:
            broken = self.command == "PUT" and cls.breaks > 0
            cls.breaks -= broken
        if broken:
            self.close_connection = True
            self.connection.close()
            return
        self.reply(answer.status, dict(answer.getheaders()), content)

    def reply(self, status, headers, content):
        self.send_response(status)
        for name, value in headers.items():
            if name.lower() not in ("transfer-encoding", "content-length", "connection", "date", "server"):
                self.send_header(name, value)
        length = headers.get("Content-Length", headers.get("content-length")) if self.command == "HEAD" else None
        self.send_header("Content-Length", length or str(len(content)))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    do_GET = do_PUT = do_HEAD = do_POST = do_DELETE = answer


moto = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
moto.start()
host, port = moto.get_host_and_port()
Proxy.target = ("127.0.0.1", port)
proxy = ThreadingHTTPServer(("127.0.0.1", 0), Proxy)
proxy.daemon_threads = True
threading.Thread(target=proxy.serve_forever, daemon=True).start()
DIRECT, THROUGH = f"http://127.0.0.1:{port}", f"http://127.0.0.1:{proxy.server_port}"


def client(service, key="test", secret="test"):
    return boto3.client(
        service, endpoint_url=DIRECT, region_name="us-east-1", aws_access_key_id=key, aws_secret_access_key=secret
    )


s3 = client("s3")
s3.create_bucket(Bucket=BUCKET)


def environment(endpoint=DIRECT, key="test", secret="test", **more):
    clean = {k: v for k, v in os.environ.items() if not k.startswith(("AWS_", "SLURM_", "JOB_"))}
    keys = {"AWS_ACCESS_KEY_ID": key, "AWS_SECRET_ACCESS_KEY": secret, "AWS_REGION": "us-east-1"}
    return clean | keys | {"AWS_ENDPOINT_URL": endpoint, "NO_PROXY": "127.0.0.1"} | more


def start(*arguments, **env):
    pipes = dict(stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    return subprocess.Popen([SATSEED, *map(str, arguments)], env=environment(**env), **pipes)


def run(*arguments, code=0, **env):
    child = start(*arguments, **env)
    out, said = child.communicate(timeout=300)
    check(child.returncode == code, f"{arguments} ended with {child.returncode} instead of {code}: {said or out}")
    return out, said


def generate(out, *more, **env):
    return run("generate", RECIPE, "--out", out, "--jobs", 1, *more, **env)


def objects(prefix, store=None):
    found = {}
    pages = (store or s3).get_paginator("list_objects_v2").paginate(Bucket=BUCKET, Prefix=f"{prefix}/")
    for page in pages:
        for entry in page.get("Contents", []):
            content = (store or s3).get_object(Bucket=BUCKET, Key=entry["Key"])["Body"].read()
            found[entry["Key"].removeprefix(f"{prefix}/")] = content
    return found


def same(prefix, expected, when):
    found = objects(prefix)
    check(found.keys() == expected.keys(), f"{when}: {sorted(found.keys() ^ expected.keys())[:5]}")
    different = [path for path in expected if found[path] != expected[path]]
    check(not different, f"{when}: {different[:5]} differ")


shutil.rmtree(FOLDER, ignore_errors=True)
generate(FOLDER)
expected = {str(p.relative_to(FOLDER)): p.read_bytes() for p in FOLDER.rglob("*") if p.is_file()}
sample = next(path for path in sorted(expected) if path.endswith("/disparity_left.tif"))

# One run, and the same command again.
root, _ = generate(f"s3://{BUCKET}/one")
same("one", expected, "one run")
check(expected["manifest.blake3"].decode().startswith(root.strip()), "the root hash is printed")
before = s3.head_object(Bucket=BUCKET, Key="one/manifest.jsonl")["LastModified"]
generate(f"s3://{BUCKET}/one")
check(s3.head_object(Bucket=BUCKET, Key="one/manifest.jsonl")["LastModified"] == before, "nothing is written twice")
report = json.loads(run("verify", f"s3://{BUCKET}/one", "--regenerate", 1, "--json")[0])
check(report["findings"] == [] and report["samples"] == 12, f"verify: {report}")
check("12 samples of 1 scenes" in run("info", f"s3://{BUCKET}/one")[0], "info")

# A changed object is named.
s3.put_object(Bucket=BUCKET, Key=f"one/{sample}", Body=expected[sample][:-1] + b"x")
report = json.loads(run("verify", f"s3://{BUCKET}/one", "--json", code=1)[0])
check([f["path"] for f in report["findings"]] == [sample], f"a changed object: {report['findings']}")

# Shards, two writers at once on each of them; then what one of them has lost is told, made again, and merged.
for shard in ("1/2", "2/2"):
    writers = [start("generate", RECIPE, "--out", f"s3://{BUCKET}/two", "--jobs", 1, "--shard", shard) for _ in range(2)]
    for writer in writers:
        said = writer.communicate(timeout=300)[1]
        check(writer.returncode == 0, f"two writers on {shard}: {said}")
    check("manifest.jsonl" not in objects("two"), "only merge joins")
lost = sample.replace("disparity_left.tif", "sample.json")
s3.delete_object(Bucket=BUCKET, Key=f"two/{lost}")
said = run("merge", f"s3://{BUCKET}/two", code=2)[1]
check(f"1 of 12 samples are missing, the first of them `{lost.removesuffix('/sample.json')}`" in said, said)
generate(f"s3://{BUCKET}/two", "--shard", "1/2")
generate(f"s3://{BUCKET}/two", "--shard", "2/2")
check(run("merge", f"s3://{BUCKET}/two")[0] == root, "the same root hash")
same("two", expected, "two writers on each shard")

# Two machines that compute differently: both hashes are shown, and what stands stays.
s3.put_object(Bucket=BUCKET, Key="differ/recipe.toml", Body=expected["recipe.toml"])
s3.put_object(Bucket=BUCKET, Key=f"differ/{sample}", Body=b"of another machine")
said = generate(f"s3://{BUCKET}/differ", "--shard", "1/2", code=2)[1] + generate(f"s3://{BUCKET}/differ", code=2)[1]
check(f"`{sample}` should be the same each time" in said and said.count("BLAKE3") == 2, said)
check(objects("differ")[sample] == b"of another machine", "nothing is replaced")

# A writer killed in mid-upload: whatever stands is whole, and the next one goes on.
Proxy.hold = sample
killed = start("generate", RECIPE, "--out", f"s3://{BUCKET}/killed", "--jobs", 1, endpoint=THROUGH)
check(Proxy.held.wait(120), "the upload began")
killed.send_signal(signal.SIGKILL)
killed.communicate()
Proxy.hold = None
standing = objects("killed")
check(all(expected[path] == content for path, content in standing.items()), "everything that stands is whole")
check(sample not in standing and lost not in standing, "what was on its way is not there")
generate(f"s3://{BUCKET}/killed")
same("killed", expected, "after a kill in mid-upload")

# A server that fails for a while, then one that loses connections after it has done what was asked.
Proxy.failures = [500, 503] * 4
Proxy.seen = 0
generate(f"s3://{BUCKET}/failing", endpoint=THROUGH)
check(not Proxy.failures and Proxy.seen > len(expected), "the failures were met")
same("failing", expected, "after 500 and 503")
Proxy.breaks = 5
generate(f"s3://{BUCKET}/broken", endpoint=THROUGH)
check(Proxy.breaks == 0, "the broken connections were met")
same("broken", expected, "after broken connections")

# One that fails for good: a sentence in time, and nothing half.
Proxy.always = 503
began = time.monotonic()
said = generate(f"s3://{BUCKET}/down", endpoint=THROUGH, code=2, SATSEED_STORE_PATIENCE_S="2")[1]
check("503" in said and "SlowDown" in said and "run the same command again" in said, said)
check(said.count("\n") == 1 and time.monotonic() - began < 60, f"one sentence in time: {said}")
Proxy.always = None
check(objects("down") == {}, "nothing was written")
said = generate(f"s3://{BUCKET}/x", endpoint="http://127.0.0.1:9", code=2, SATSEED_STORE_PATIENCE_S="1")[1]
check("s3://datasets/x" in said and said.count("\n") == 1, said)
said = generate("s3://no-such-bucket/x", code=2)[1]
check("there is no such bucket" in said, said)
said = run("verify", f"s3://{BUCKET}/nothing", "--json", code=1)[0]
check("manifest.jsonl" in said, said)

if CONFORMANCE:
    store = {"SATSEED_TEST_STORE": f"s3://{BUCKET}/conformance"}
    done = subprocess.run(CONFORMANCE, env=environment(**store), capture_output=True, text=True)
    check(done.returncode == 0 and "1 passed" in done.stdout, f"conformance: {done.stdout[-2000:]} {done.stderr[-2000:]}")
    left = [u for u in s3.list_multipart_uploads(Bucket=BUCKET).get("Uploads", [])]
    check(left == [], f"unfinished uploads: {left}")

# From here on the server looks at keys.
iam = client("iam")
iam.create_user(UserName="writer")
policy = {"Version": "2012-10-17", "Statement": [{"Effect": "Allow", "Action": "s3:*", "Resource": "*"}]}
iam.put_user_policy(UserName="writer", PolicyName="all", PolicyDocument=json.dumps(policy))
made = iam.create_access_key(UserName="writer")["AccessKey"]
key, secret = made["AccessKeyId"], made["SecretAccessKey"]
settings.INITIAL_NO_AUTH_ACTION_COUNT = 0.0
for wrong in ({"key": "AKIANOBODY", "secret": "x"}, {"key": key, "secret": "x"}):
    said = generate(f"s3://{BUCKET}/keys", code=2, **wrong)[1]
    check("refuses these credentials" in said and "AWS_ACCESS_KEY_ID" in said and said.count("\n") == 1, said)
    check(wrong["secret"] not in said.split(), "no secret is printed")
profile = FOLDER.parent / "s3-credentials"
profile.write_text(f"[default]\naws_access_key_id = no\n[work]\naws_access_key_id = {key}\naws_secret_access_key = {secret}\n")
env = environment(AWS_PROFILE="work", AWS_SHARED_CREDENTIALS_FILE=str(profile))
del env["AWS_ACCESS_KEY_ID"], env["AWS_SECRET_ACCESS_KEY"]
done = subprocess.run([SATSEED, "generate", RECIPE, "--out", f"s3://{BUCKET}/keys"], env=env, capture_output=True, text=True)
check(done.returncode == 0, f"a profile: {done.stderr}")
right = client("s3", key, secret)
check(objects("keys", right) == expected, "with the right key")
moto.stop()
shutil.rmtree(FOLDER)
profile.unlink()
print(f"s3.py: {checks} checks")
