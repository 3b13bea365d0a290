#!/bin/sh
# A sweep with the scheduler on one host and the workers on another: two network namespaces joined by a
# virtual cable; the folder of the plan and the temporary folder are not there on the second host.
# usage: dask_in_namespaces.sh PYTHON SCRIPT PLAN   in the folder of the plan
set -eu
python=$1 script=$2 plan=$3
ns=pd$$
started=""
end() {
    for process in $started; do kill "$process" 2>/dev/null || true; done
    ip netns del "${ns}a" 2>/dev/null || true
    ip netns del "${ns}b" 2>/dev/null || true
}
trap end EXIT
if ! { ip netns add "${ns}a" && ip netns add "${ns}b" &&
    ip link add "${ns}x" netns "${ns}a" type veth peer name "${ns}y" netns "${ns}b"; } 2>/dev/null; then
    echo "SKIPPED: Dask across network namespaces (no privilege to make them)"
    exit 0
fi
ip -n "${ns}a" addr add 10.78.0.1/24 dev "${ns}x" && ip -n "${ns}a" link set "${ns}x" up
ip -n "${ns}b" addr add 10.78.0.2/24 dev "${ns}y" && ip -n "${ns}b" link set "${ns}y" up
ip -n "${ns}a" link set lo up
ip -n "${ns}b" link set lo up
here=$(pwd)
ip netns exec "${ns}a" "$python" -m distributed.cli.dask_scheduler --host 10.78.0.1 --port 8786 --no-dashboard \
    > scheduler.txt 2>&1 &
started=$!
# The second host has an empty disk in the place of the plan's.
ip netns exec "${ns}b" unshare -m sh -eu -c "
    mount -t tmpfs none '$here'
    mkdir '$here/tmp'
    export TMPDIR='$here/tmp'
    cd '$here/tmp'
    [ ! -e '$here/$plan' ]
    exec '$python' -m distributed.cli.dask_worker tcp://10.78.0.1:8786 --host 10.78.0.2 --nworkers 2 --nthreads 1 \
        --no-dashboard --local-directory '$here/tmp'" > worker.txt 2>&1 &
started="$started $!"
if ! ip netns exec "${ns}a" "$python" "$script" "$plan" tcp://10.78.0.1:8786; then
    cat scheduler.txt worker.txt
    exit 1
fi
