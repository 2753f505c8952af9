"""Signatures and keys of `sightline` checked by programs that share no code with it: minisign, and
OpenSSL with Python's own BLAKE2b. usage: independent_check.py SIGHTLINE"""

import base64
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile

KEY_COUNT = 3
SPKI_ED25519 = bytes.fromhex("302a300506032b6570032100")  # RFC 8410, before the point


def run(*command, ok=True, **options):
    done = subprocess.run(command, capture_output=True, text=True, **options)
    if ok and done.returncode != 0:
        sys.exit(f"{command}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done


def openssl_verifies(point, signature, message):
    with open("key.der", "wb") as file:
        file.write(SPKI_ED25519 + point)
    for name, content in (("sig.bin", signature), ("message.bin", message)):
        with open(name, "wb") as file:
            file.write(content)
    return run("openssl", "pkeyutl", "-verify", "-pubin", "-inkey", "key.der", "-keyform", "DER", "-rawin",
               "-in", "message.bin", "-sigfile", "sig.bin", ok=False).returncode == 0


def check_with_openssl(record, keys):
    """Every signature of the file by the published form alone."""
    message = hashlib.blake2b(open(record, "rb").read()).digest()
    lines = open(record + ".minisig").read().splitlines()
    assert len(lines) == 4 * len(keys), lines
    for i, key in enumerate(keys):
        public = base64.b64decode(open(key + ".pub").read().splitlines()[1])
        first = base64.b64decode(lines[4 * i + 1])
        last = base64.b64decode(lines[4 * i + 3])
        comment = lines[4 * i + 2].removeprefix("trusted comment: ").encode()
        assert public[:2] == b"Ed" and first[:2] == b"ED" and public[2:10] == first[2:10]
        assert openssl_verifies(public[10:], first[10:], message)
        assert openssl_verifies(public[10:], last, first[10:] + comment)
        assert not openssl_verifies(public[10:], first[10:], message[:-1] + bytes([message[-1] ^ 1]))


def main(sightline):
    for i in range(KEY_COUNT):
        run(sightline, "key", f"k{i}")
        assert os.stat(f"k{i}.key").st_mode & 0o777 == 0o600
    assert run(sightline, "key", "k0", ok=False).returncode == 64, "a secret key is never replaced"
    shared = open("k0.pub").read()
    os.remove("k0.pub")
    run(sightline, "key", "k0")
    assert open("k0.pub").read() == shared, "the half that is there is completed"
    os.rename("k0.key", "away")
    assert run(sightline, "key", "k0", ok=False).returncode == 64, "another's public key is not replaced"
    assert not os.path.exists("k0.key")
    os.rename("away", "k0.key")
    keys = [f"k{i}" for i in range(KEY_COUNT)]
    flags = sum((["--signer", key + ".pub"] for key in keys), [])
    run(sightline, "root", "--fleet", "metropolis", *flags, "--threshold", "2", "-o", "root.1")
    for key in keys:
        run(sightline, "sign", "root.1", "--key", key + ".key")
    assert run(sightline, "sign", "root.1", "--key", "k1.key", ok=False).returncode == 64, "signed twice"
    check_with_openssl("root.1", keys)

    # A stock minisign verifies the first signature, and the others without those before them.
    lines = open("root.1.minisig").read().splitlines(keepends=True)
    for i, key in enumerate(keys):
        with open("one.minisig", "w") as file:
            file.writelines(lines[4 * i:])
        run("minisign", "-V", "-p", key + ".pub", "-x", "one.minisig", "-m", "root.1")
    run("minisign", "-V", "-p", "k0.pub", "-m", "root.1")

    # And the other way round: a key and a signature that minisign made.
    run("minisign", "-G", "-W", "-p", "m.pub", "-s", "m.key")
    run(sightline, "root", "--previous", "root.1", "--signer", "m.pub", "--signer", "k1.pub", "--threshold", "2", "-o",
        "root.2")
    run(sightline, "sign", "root.2", "--key", "k0.key")
    run(sightline, "sign", "root.2", "--key", "k1.key")
    run("minisign", "-S", "-s", "m.key", "-m", "root.2", "-x", "m.minisig")
    with open("root.2.minisig", "a") as file:
        file.write(open("m.minisig").read())
    run(sightline, "admit", "--root", "root.1", "--next-root", "root.2")
    run(sightline, "root", "--previous", "root.2", *flags, "--threshold", "1", "-o", "root.3")
    run(sightline, "sign", "root.3", "--key", "m.key")  # minisign's secret key, without a passphrase
    check_with_openssl("root.3", ["m"])

    # A passphrase.
    with open("phrase", "w") as file:
        file.write("open sesame\nsecond line\n")
    run(sightline, "key", "locked", "--passphrase-file", "phrase")
    assert run(sightline, "sign", "root.3", "--key", "locked.key", ok=False).returncode == 68
    run(sightline, "sign", "root.3", "--key", "locked.key", "--passphrase-file", "phrase")
    check_with_openssl("root.3", ["m", "locked"])
    print("minisign and OpenSSL agree")


if __name__ == "__main__":
    missing = [program for program in ("minisign", "openssl") if not shutil.which(program)]
    if missing:
        print(f"skipped: no {' and no '.join(missing)} here")
        sys.exit(77)
    sightline_program = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        main(sightline_program)
