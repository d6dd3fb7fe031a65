#!/usr/bin/env bash
# publish.sh BRANCH PATH SOURCE: commits SOURCE, a file or folder, as PATH on a branch that has no other history than its own.
set -eu
branch=$1 path=$2 source=$(realpath "$3")
work=$(mktemp -d)
if git fetch --quiet --depth=1 origin "$branch"; then
  git worktree add --quiet --detach "$work" FETCH_HEAD
else
  git worktree add --quiet --detach "$work"
  git -C "$work" checkout --quiet --orphan "$branch"
  git -C "$work" rm --quiet -rf .
fi
cd "$work"
rm -rf "./${path:?}"
mkdir -p "$(dirname "$path")"
cp -r "$source" "$path"
git add --all
git diff --cached --quiet && exit 0
git -c user.name=ci -c user.email=ci@localhost commit --quiet --message "$path"
git push --quiet origin "HEAD:refs/heads/$branch"
